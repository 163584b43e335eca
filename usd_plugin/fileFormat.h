#pragma once

#include <pxr/pxr.h>
#include <pxr/usd/pcp/dynamicFileFormatInterface.h>
#include <pxr/usd/sdf/fileFormat.h>

#include <set>
#include <string>

PXR_NAMESPACE_OPEN_SCOPE

/// The file format `.tailor`: a recipe in JSON that opens as the layer that `usdtailor build` writes.
class TailorFileFormat final : public SdfFileFormat, public PcpDynamicFileFormatInterface {
public:
    bool CanRead(const std::string &path) const override;
    bool Read(SdfLayer *layer, const std::string &resolvedPath, bool metadataOnly) const override;

    /// The source files of the layer, so that a reload sees their edits.
    std::set<std::string> GetExternalAssetDependencies(const SdfLayer &layer) const override;

    // The layer as text. Without these two functions, the exported text is empty.
    bool WriteToString(const SdfLayer &layer, std::string *text, const std::string &comment) const override;
    bool WriteToStream(const SdfSpecHandle &spec, std::ostream &stream, size_t indent) const override;

    void ComposeFieldsForFileFormatArguments(
        const std::string &assetPath, const PcpDynamicFileFormatContext &context, FileFormatArguments *arguments,
        VtValue *contextDependencyData) const override;
    bool CanFieldChangeAffectFileFormatArguments(
        const TfToken &field, const VtValue &oldValue, const VtValue &newValue,
        const VtValue &contextDependencyData) const override;
    bool CanAttributeDefaultValueChangeAffectFileFormatArguments(
        const TfToken &attributeName, const VtValue &oldValue, const VtValue &newValue,
        const VtValue &contextDependencyData) const override;

protected:
    SDF_FILE_FORMAT_FACTORY_ACCESS;
    TailorFileFormat();
    ~TailorFileFormat() override;
};

PXR_NAMESPACE_CLOSE_SCOPE
