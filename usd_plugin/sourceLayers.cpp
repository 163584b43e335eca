#include "sourceLayers.h"

#include "errors.h"
#include "source.h"

#include <pxr/usd/ar/resolver.h>
#include <pxr/usd/sdf/layer.h>
#include <pxr/usd/sdf/layerUtils.h>

#include <exception>
#include <map>
#include <mutex>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// The source layers of each `.tailor` file at its last read.
///
/// OpenUSD asks for them after each read, when the layers may already be closed, and before each reload. It compares
/// the files' modification times to find changes.
class Memory {
public:
    void Set(const std::string &path, const std::set<std::string> &identifiers)
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        _identifiers[path] = identifiers;
    }
    std::set<std::string> Get(const std::string &path)
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        const auto found = _identifiers.find(path);
        return found == _identifiers.end() ? std::set<std::string>() : found->second;
    }

private:
    std::mutex _mutex;
    std::map<std::string, std::set<std::string>> _identifiers;
};

Memory &GetMemory()
{
    static Memory memory;
    return memory;
}

std::string WithoutArguments(const std::string &identifier)
{
    std::string path;
    SdfLayer::FileFormatArguments arguments;
    return SdfLayer::SplitIdentifier(identifier, &path, &arguments) ? path : identifier;
}

} // namespace

TailorSourceLayers::TailorSourceLayers(const std::string &resolvedPath, const std::string &source, bool reload)
    : _path(resolvedPath), _reload(reload), _chain{resolvedPath}
{
    // The stage reports layers that cannot be opened.
    const TailorPostedErrors ignored;
    try {
        _Visit(source);
    } catch (...) {
        GetMemory().Set(_path, _identifiers);
        throw;
    }
    GetMemory().Set(_path, _identifiers);
    if (_reload) {
        _ReloadRecipes();
    }
}

void TailorSourceLayers::_Visit(const std::string &identifier)
{
    const std::string path = WithoutArguments(identifier);
    const std::string resolved = ArGetResolver().Resolve(path).GetPathString();
    _CheckCycle(resolved);
    // Missing files are remembered too, as they may appear later.
    if (!_identifiers.insert(path).second || resolved.empty()) {
        return;
    }
    _chain.push_back(path);
    if (TailorIsRecipe(path)) {
        _VisitRecipe(resolved);
    } else {
        _VisitLayer(identifier);
    }
    _chain.pop_back();
}

void TailorSourceLayers::_VisitRecipe(const std::string &resolvedPath)
{
    _recipes.insert(resolvedPath);
    std::string source;
    try {
        source = TailorGetSource(*TailorReadDocument(resolvedPath, {}), resolvedPath);
    } catch (const std::exception &) {
        // The error is reported when the file is opened as a layer.
        return;
    }
    _Visit(source);
}

void TailorSourceLayers::_VisitLayer(const std::string &identifier)
{
    const SdfLayerRefPtr layer = SdfLayer::FindOrOpen(identifier);
    if (!layer) {
        return;
    }
    _layers.push_back(layer);
    if (_reload && !layer->IsDirty()) {
        layer->Reload();
    }
    for (const std::string &dependency : layer->GetCompositionAssetDependencies()) {
        if (dependency.front() == '`') {
            _CheckExpression(identifier, dependency);
        } else {
            _Visit(SdfComputeAssetPathRelativeToLayer(layer, dependency));
        }
    }
}

void TailorSourceLayers::_CheckExpression(const std::string &identifier, const std::string &expression) const
{
    // The value depends on the stage, which must not be opened before cycles are excluded.
    if (expression.find(".tailor") != std::string::npos) {
        throw TailorFault(
            _path, "its source may use the file itself: " + expression + " in " + identifier,
            "name .tailor files without variables inside a source");
    }
}

void TailorSourceLayers::_CheckCycle(const std::string &resolvedPath) const
{
    if (resolvedPath != _path) {
        return;
    }
    std::string chain;
    for (const std::string &path : _chain) {
        chain += path + " -> ";
    }
    throw TailorFault(
        _path, "its source uses the file itself: " + chain + _path,
        "let the source be the garment alone, and use the .tailor file in another layer");
}

void TailorSourceLayers::_ReloadRecipes() const
{
    for (const SdfLayerHandle &layer : SdfLayer::GetLoadedLayers()) {
        if (layer && _recipes.count(layer->GetResolvedPath().GetPathString())) {
            layer->Reload();
        }
    }
}

std::set<std::string> TailorGetRememberedLayers(const std::string &resolvedPath)
{
    return GetMemory().Get(resolvedPath);
}

PXR_NAMESPACE_CLOSE_SCOPE
