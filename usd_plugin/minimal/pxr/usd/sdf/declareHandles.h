#pragma once

#include <pxr/base/tf/refPtr.h>
#include <pxr/base/tf/weakPtr.h>

#include <set>

PXR_NAMESPACE_OPEN_SCOPE

class SdfAbstractData;
class SdfFileFormat;
class SdfLayer;
class SdfSpec;
template <class T>
class SdfHandle;

using SdfAbstractDataRefPtr = TfRefPtr<SdfAbstractData>;
using SdfFileFormatRefPtr = TfRefPtr<SdfFileFormat>;
using SdfFileFormatConstPtr = TfWeakPtr<const SdfFileFormat>;
using SdfLayerRefPtr = TfRefPtr<SdfLayer>;
using SdfLayerHandle = TfWeakPtr<SdfLayer>;
using SdfLayerHandleSet = std::set<SdfLayerHandle>;
using SdfSpecHandle = SdfHandle<SdfSpec>;

PXR_NAMESPACE_CLOSE_SCOPE
