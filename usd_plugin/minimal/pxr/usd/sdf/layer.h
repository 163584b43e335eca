#pragma once

#include <pxr/usd/ar/resolvedPath.h>
#include <pxr/usd/sdf/declareHandles.h>

#include <map>
#include <set>
#include <string>

PXR_NAMESPACE_OPEN_SCOPE

class SdfLayer {
public:
    using FileFormatArguments = std::map<std::string, std::string>;

    SdfLayer() = delete;
    static SdfLayerRefPtr FindOrOpen(
        const std::string &identifier, const FileFormatArguments &arguments = FileFormatArguments());
    static SdfLayerHandleSet GetLoadedLayers();
    static bool SplitIdentifier(const std::string &identifier, std::string *path, FileFormatArguments *arguments);
    const std::string &GetIdentifier() const;
    const ArResolvedPath &GetResolvedPath() const;
    const FileFormatArguments &GetFileFormatArguments() const;
    std::set<std::string> GetCompositionAssetDependencies() const;
    bool IsAnonymous() const;
    bool IsDirty() const;
    bool IsEmpty() const;
    bool Reload(bool force = false);
};

PXR_NAMESPACE_CLOSE_SCOPE
