#pragma once

#include <pxr/pxr.h>
#include <pxr/usd/sdf/declareHandles.h>

#include <set>
#include <string>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

/// Finds the source layers of a `.tailor` file and detects cycles.
///
/// No `.tailor` file is opened as a layer for this: a source that uses the file itself would deadlock.
class TailorSourceLayers {
public:
    /// Throws TailorFault if the source uses the file at `resolvedPath`. With `reload`, open layers without unsaved
    /// edits are read from disk again.
    TailorSourceLayers(const std::string &resolvedPath, const std::string &source, bool reload);

private:
    void _Visit(const std::string &identifier);
    void _VisitRecipe(const std::string &resolvedPath);
    void _VisitLayer(const std::string &identifier);
    void _CheckExpression(const std::string &identifier, const std::string &expression) const;
    void _CheckCycle(const std::string &resolvedPath) const;
    void _ReloadRecipes() const;

    std::string _path;
    bool _reload;
    /// The path of the search from the file to the current layer.
    std::vector<std::string> _chain;
    /// Identifiers without arguments.
    std::set<std::string> _identifiers;
    std::set<std::string> _recipes;
    /// Keeps the layers open while the source is composed, so that none is read twice.
    std::vector<SdfLayerRefPtr> _layers;
};

/// The identifiers of the source layers when the file was last read.
std::set<std::string> TailorGetRememberedLayers(const std::string &resolvedPath);

PXR_NAMESPACE_CLOSE_SCOPE
