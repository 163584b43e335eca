#pragma once

#include <pxr/usd/sdf/layer.h>

PXR_NAMESPACE_OPEN_SCOPE

std::string SdfComputeAssetPathRelativeToLayer(const SdfLayerHandle &anchor, const std::string &assetPath);

PXR_NAMESPACE_CLOSE_SCOPE
