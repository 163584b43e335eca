#pragma once

#include <pxr/pxr.h>
#include <pxr/usd/sdf/declareHandles.h>

#include <set>
#include <string>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

/// The layers that a `.tailor` file is made from, found without opening any `.tailor` file as a layer: a source that
/// uses the file again would wait for itself for ever.
class TailorSourceLayers {
public:
    /// Throws when the source leads back to `resolvedPath`. With `reload`, layers that are in memory and have no edits
    /// of their own are taken from disk again, as is the reloaded layer itself.
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
    /// From the file to where the search is.
    std::vector<std::string> _chain;
    /// Identifiers without arguments.
    std::set<std::string> _identifiers;
    std::set<std::string> _recipes;
    /// Open as long as the source is being composed, so that none is read twice.
    std::vector<SdfLayerRefPtr> _layers;
};

/// The identifiers of those layers when the file was last read.
std::set<std::string> TailorGetRememberedLayers(const std::string &resolvedPath);

PXR_NAMESPACE_CLOSE_SCOPE
