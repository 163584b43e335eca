#pragma once

#include <pxr/base/vt/value.h>
#include <pxr/usd/sdf/fileFormat.h>

#include <string>

PXR_NAMESPACE_OPEN_SCOPE

class PcpDynamicFileFormatContext;

class PcpDynamicFileFormatInterface {
public:
    virtual ~PcpDynamicFileFormatInterface();
    virtual void ComposeFieldsForFileFormatArguments(
        const std::string &assetPath, const PcpDynamicFileFormatContext &context,
        SdfFileFormat::FileFormatArguments *arguments, VtValue *contextDependencyData) const = 0;
    virtual bool CanFieldChangeAffectFileFormatArguments(
        const TfToken &field, const VtValue &oldValue, const VtValue &newValue,
        const VtValue &contextDependencyData) const;
    virtual bool CanAttributeDefaultValueChangeAffectFileFormatArguments(
        const TfToken &attributeName, const VtValue &oldValue, const VtValue &newValue,
        const VtValue &contextDependencyData) const;
};

PXR_NAMESPACE_CLOSE_SCOPE
