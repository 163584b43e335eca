#pragma once

#include <pxr/usd/ar/resolverContext.h>
#include <pxr/usd/sdf/declareHandles.h>

#include <string>

PXR_NAMESPACE_OPEN_SCOPE

class UsdStage;
using UsdStageRefPtr = TfRefPtr<UsdStage>;

class UsdStage {
public:
    enum InitialLoadSet { LoadAll, LoadNone };

    UsdStage() = delete;
    static UsdStageRefPtr Open(
        const std::string &filePath, const ArResolverContext &pathResolverContext, InitialLoadSet load = LoadAll);
    SdfLayerRefPtr Flatten(bool addSourceFileComment = true) const;
};

PXR_NAMESPACE_CLOSE_SCOPE
