// What the minimal headers declare, in a form that `cargo xtask plugin` reads and compares with a wheel: a class below
// each one that the plugin derives from, or calls through its virtual table, and the places of members.
#include <pxr/usd/ar/asset.h>
#include <pxr/usd/pcp/dynamicFileFormatInterface.h>
#include <pxr/usd/sdf/fileFormat.h>

#include <cstddef>

#pragma GCC diagnostic ignored "-Winvalid-offsetof"

PXR_NAMESPACE_OPEN_SCOPE

struct TailorProbeFormat : SdfFileFormat {
    ~TailorProbeFormat() override;
    bool CanRead(const std::string &) const override;
    bool Read(SdfLayer *, const std::string &, bool) const override;
};
TailorProbeFormat::~TailorProbeFormat() = default;
bool TailorProbeFormat::CanRead(const std::string &) const
{
    return false;
}
bool TailorProbeFormat::Read(SdfLayer *, const std::string &, bool) const
{
    return false;
}

struct TailorProbeDynamic : PcpDynamicFileFormatInterface {
    ~TailorProbeDynamic() override;
    void ComposeFieldsForFileFormatArguments(
        const std::string &, const PcpDynamicFileFormatContext &, SdfFileFormat::FileFormatArguments *,
        VtValue *) const override;
};
TailorProbeDynamic::~TailorProbeDynamic() = default;
void TailorProbeDynamic::ComposeFieldsForFileFormatArguments(
    const std::string &, const PcpDynamicFileFormatContext &, SdfFileFormat::FileFormatArguments *, VtValue *) const
{
}

struct TailorProbeFactory : Sdf_FileFormatFactoryBase {
    ~TailorProbeFactory() override;
    SdfFileFormatRefPtr New() const override;
};
TailorProbeFactory::~TailorProbeFactory() = default;
SdfFileFormatRefPtr TailorProbeFactory::New() const
{
    return {};
}

struct TailorProbeAsset : ArAsset {
    ~TailorProbeAsset() override;
    size_t GetSize() const override;
    std::shared_ptr<const char> GetBuffer() const override;
    size_t Read(void *, size_t, size_t) const override;
    std::pair<FILE *, size_t> GetFileUnsafe() const override;
};
TailorProbeAsset::~TailorProbeAsset() = default;
size_t TailorProbeAsset::GetSize() const
{
    return 0;
}
std::shared_ptr<const char> TailorProbeAsset::GetBuffer() const
{
    return nullptr;
}
size_t TailorProbeAsset::Read(void *, size_t, size_t) const
{
    return 0;
}
std::pair<FILE *, size_t> TailorProbeAsset::GetFileUnsafe() const
{
    return {};
}

struct TailorProbeLayout {
    static constexpr int members[] = {
        // `_schema` is a reference, and the first member after the bases.
        sizeof(TfRefBase) + sizeof(TfWeakBase),
        offsetof(SdfFileFormat, _formatId),
#ifndef TAILOR_BREAK_MEMBERS
        offsetof(SdfFileFormat, _target),
#else
        -1,
#endif
        offsetof(SdfFileFormat, _cookie),
        offsetof(SdfFileFormat, _versionString),
        offsetof(SdfFileFormat, _extensions),
        offsetof(SdfFileFormat, _isPrimaryFormat),
        sizeof(SdfFileFormat),
    };
};

PXR_NAMESPACE_CLOSE_SCOPE

// A copy with a plain name; the order is that of the check.
extern "C" __attribute__((used)) const int tailorProbeLayout[8] = {
    pxr::TailorProbeLayout::members[0], pxr::TailorProbeLayout::members[1], pxr::TailorProbeLayout::members[2],
    pxr::TailorProbeLayout::members[3], pxr::TailorProbeLayout::members[4], pxr::TailorProbeLayout::members[5],
    pxr::TailorProbeLayout::members[6], pxr::TailorProbeLayout::members[7],
};
