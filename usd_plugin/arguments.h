#pragma once

#include <pxr/pxr.h>
#include <pxr/usd/sdf/fileFormat.h>

#include <string>

PXR_NAMESPACE_OPEN_SCOPE

class PcpDynamicFileFormatContext;
class TfToken;

/// Adds an argument for each option that the prim with the payload, or a stronger opinion, has as an attribute.
void TailorComposeArguments(
    const std::string &assetPath, const PcpDynamicFileFormatContext &context,
    SdfFileFormat::FileFormatArguments *arguments);

/// Whether an attribute is one of those.
bool TailorIsArgument(const TfToken &attributeName);

PXR_NAMESPACE_CLOSE_SCOPE
