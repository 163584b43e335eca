#pragma once

#include <pxr/base/tf/token.h>
#include <pxr/base/tf/type.h>
#include <pxr/usd/sdf/declareHandles.h>

#include <iosfwd>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <typeinfo>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

class ArAssetInfo;
class SdfSchemaBase;

// The TAILOR_BREAK_ switches make the declarations wrong, for the tests of the check against the wheel.
class SdfFileFormat : public TfRefBase, public TfWeakBase {
public:
    using FileFormatArguments = std::map<std::string, std::string>;

    SdfFileFormat(const SdfFileFormat &) = delete;
    SdfFileFormat &operator=(const SdfFileFormat &) = delete;

    virtual bool IsPackage() const;
    virtual std::string GetPackageRootLayerPath(const std::string &resolvedPath) const;
    virtual FileFormatArguments GetDefaultFileFormatArguments() const;
    virtual SdfAbstractDataRefPtr InitData(const FileFormatArguments &arguments) const;
    virtual bool CanRead(const std::string &file) const = 0;
    virtual bool Read(SdfLayer *layer, const std::string &resolvedPath, bool metadataOnly) const = 0;
    bool ReadDetached(SdfLayer *layer, const std::string &resolvedPath, bool metadataOnly) const;
    virtual bool WriteToFile(
        const SdfLayer &layer, const std::string &filePath, const std::string &comment = std::string(),
        const FileFormatArguments &arguments = FileFormatArguments()) const;
    virtual bool SaveToFile(
        const SdfLayer &layer, const std::string &filePath, const std::string &comment = std::string(),
        const FileFormatArguments &arguments = FileFormatArguments()) const;
#ifndef TAILOR_BREAK_SLOTS
    virtual bool ReadFromString(SdfLayer *layer, const std::string &text) const;
    virtual bool WriteToStream(const SdfSpecHandle &spec, std::ostream &stream, size_t indent) const;
#else
    virtual bool WriteToStream(const SdfSpecHandle &spec, std::ostream &stream, size_t indent) const;
    virtual bool ReadFromString(SdfLayer *layer, const std::string &text) const;
#endif
    virtual bool WriteToString(
        const SdfLayer &layer, std::string *text, const std::string &comment = std::string()) const;
    virtual std::set<std::string> GetExternalAssetDependencies(const SdfLayer &layer) const;

    static SdfFileFormatConstPtr FindById(const TfToken &formatId);
    static std::string GetFileExtension(const std::string &path);

protected:
    SdfFileFormat(
        const TfToken &formatId, const TfToken &versionString, const TfToken &target, const std::string &extension);
    ~SdfFileFormat() override;
    virtual SdfLayer *_InstantiateNewLayer(
        const SdfFileFormatConstPtr &fileFormat, const std::string &identifier, const std::string &realPath,
        const ArAssetInfo &assetInfo, const FileFormatArguments &arguments) const;
    virtual bool _ShouldSkipAnonymousReload() const;
    virtual bool _ShouldReadAnonymousLayers() const;
    virtual SdfAbstractDataRefPtr _InitDetachedData(const FileFormatArguments &arguments) const;
    virtual bool _ReadDetached(SdfLayer *layer, const std::string &resolvedPath, bool metadataOnly) const;

private:
    friend struct TailorProbeLayout;
    const SdfSchemaBase &_schema;
    const TfToken _formatId;
#ifndef TAILOR_BREAK_MEMBERS
    const TfToken _target;
#endif
    const std::string _cookie;
    const TfToken _versionString;
    const std::vector<std::string> _extensions;
    const bool _isPrimaryFormat;
};

class Sdf_FileFormatFactoryBase : public TfType::FactoryBase {
public:
    ~Sdf_FileFormatFactoryBase() override;
    virtual SdfFileFormatRefPtr New() const = 0;
};

template <typename T>
class Sdf_FileFormatFactory : public Sdf_FileFormatFactoryBase {
public:
    SdfFileFormatRefPtr New() const override { return TfCreateRefPtr<SdfFileFormat>(new T); }
};

template <class FileFormat, class... Bases>
void SdfDefineFileFormat()
{
    TfType::FindByName(TfType::GetCanonicalTypeName(typeid(FileFormat)))
        .SetFactory(std::unique_ptr<TfType::FactoryBase>(new Sdf_FileFormatFactory<FileFormat>));
}

#define SDF_DEFINE_FILE_FORMAT(...) SdfDefineFileFormat<__VA_ARGS__>()
#define SDF_FILE_FORMAT_FACTORY_ACCESS                                                                                 \
    template <typename T>                                                                                              \
    friend class Sdf_FileFormatFactory

PXR_NAMESPACE_CLOSE_SCOPE
