#pragma once

#include <pxr/pxr.h>
#include <pxr/usd/sdf/fileFormat.h>

#include <string>

PXR_NAMESPACE_OPEN_SCOPE

class PcpDynamicFileFormatContext;
class TfToken;

/// Adds an argument for each option that is an attribute of the payload's prim. Seams and folds are those named
/// in the file, the prim's schemas or the arguments of `assetPath`.
void TailorComposeArguments(
    const std::string &assetPath, const PcpDynamicFileFormatContext &context,
    SdfFileFormat::FileFormatArguments *arguments);

/// True if an attribute can be one of those.
bool TailorIsArgument(const TfToken &attributeName);

/// True if a field of the prim names seams and folds, so that its change affects the attributes to read.
bool TailorNamesInstances(const TfToken &field);

PXR_NAMESPACE_CLOSE_SCOPE
