#pragma once

#include <pxr/pxr.h>
#include <pxr/usd/sdf/fileFormat.h>

#include <string>

PXR_NAMESPACE_OPEN_SCOPE

class PcpDynamicFileFormatContext;
class TfToken;

/// Adds an argument for each option that the prim with the payload, or a stronger opinion, has as an attribute. Its seams
/// and thicknesses are those that the file, the prim's schemas or the arguments of `assetPath` name.
void TailorComposeArguments(
    const std::string &assetPath, const PcpDynamicFileFormatContext &context,
    SdfFileFormat::FileFormatArguments *arguments);

/// Whether an attribute can be one of those.
bool TailorIsArgument(const TfToken &attributeName);

/// Whether a field of the prim names seams and thicknesses, so that others of its attributes are read when it changes.
bool TailorNamesInstances(const TfToken &field);

PXR_NAMESPACE_CLOSE_SCOPE
