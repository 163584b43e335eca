#pragma once

#include <pxr/base/tf/token.h>
#include <pxr/base/vt/value.h>

#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

class PcpDynamicFileFormatContext {
public:
    PcpDynamicFileFormatContext() = delete;
    bool ComposeValueStack(const TfToken &fieldName, std::vector<VtValue> *values) const;
    bool ComposeAttributeDefaultValue(const TfToken &attributeName, VtValue *value) const;
};

PXR_NAMESPACE_CLOSE_SCOPE
