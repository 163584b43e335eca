#include "source.h"

#include "errors.h"
#include "sourceLayers.h"

#include <pxr/base/tf/diagnostic.h>
#include <pxr/base/tf/pathUtils.h>
#include <pxr/base/tf/token.h>
#include <pxr/usd/ar/asset.h>
#include <pxr/usd/ar/resolver.h>
#include <pxr/usd/ar/resolverContext.h>
#include <pxr/usd/ar/resolverContextBinder.h>
#include <pxr/usd/sdf/layer.h>
#include <pxr/usd/usd/stage.h>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

rust::Vec<tailor::Argument> Arguments(const SdfFileFormat::FileFormatArguments &arguments)
{
    rust::Vec<tailor::Argument> all;
    for (const auto &[key, value] : arguments) {
        // OpenUSD's own argument, which selects one of several formats with the same extension.
        if (key != "target") {
            all.push_back({rust::String(key), rust::String(value)});
        }
    }
    return all;
}

/// The resolver context of the stage that is composing. Without one, the default context of the source.
ArResolverContext Context(const std::string &source)
{
    const ArResolver &resolver = ArGetResolver();
    const ArResolverContext current = resolver.GetCurrentContext();
    return current.IsEmpty() ? resolver.CreateDefaultContextForAsset(source) : current;
}

/// The package path of a relative `source` of a `.tailor` file in a package (`outer.usdz[inner.tailor]`); empty for
/// other files. The resolver alone would search in the package's own folder.
std::string InPackage(const std::string &source, const std::string &resolvedPath)
{
    const size_t bracket = resolvedPath.rfind('[');
    if (bracket == std::string::npos || resolvedPath.back() != ']' || !TfIsRelativePath(source) ||
        source.find(':') != std::string::npos) {
        return std::string();
    }
    const size_t end = resolvedPath.find(']', bracket);
    const std::string inner = resolvedPath.substr(bracket + 1, end - bracket - 1);
    const std::string entry = TfNormPath(TfGetPathName(inner) + source);
    return resolvedPath.substr(0, bracket + 1) + entry + resolvedPath.substr(end);
}

SdfLayerRefPtr
Flatten(const std::string &path, const std::string &source, const ArResolverContext &context)
{
    const TailorPostedErrors posted;
    const UsdStageRefPtr stage = UsdStage::Open(source, context);
    const SdfLayerRefPtr flattened = stage ? stage->Flatten(false) : SdfLayerRefPtr();
    const std::string errors = posted.Take();
    if (!flattened) {
        throw TailorFault(
            path, "its source " + source + " cannot be opened: " + errors,
            "\"source\" names a USD file that opens by itself, such as coat.usda");
    }
    if (!errors.empty()) {
        TF_WARN("%s: its source %s does not compose fully: %s", path.c_str(), source.c_str(), errors.c_str());
    }
    return flattened;
}

} // namespace

bool TailorIsRecipe(const std::string &path)
{
    return SdfFileFormat::GetFileExtension(path) == "tailor";
}

TailorRecipeText::TailorRecipeText(const ArResolvedPath &path)
    : _asset(ArGetResolver().OpenAsset(path)), _text(_asset ? _asset->GetBuffer() : nullptr)
{
    // An empty file also has no buffer; the parser reports it.
    if (!_text && _asset && _asset->GetSize() > 0) {
        _asset.reset();
    }
}

rust::Slice<const uint8_t> TailorRecipeText::GetBytes() const
{
    return {reinterpret_cast<const uint8_t *>(_text.get()), _text ? _asset->GetSize() : 0};
}

rust::Box<tailor::Document>
TailorReadDocument(const std::string &resolvedPath, const SdfFileFormat::FileFormatArguments &arguments)
{
    const TailorRecipeText text{ArResolvedPath(resolvedPath)};
    if (!text.IsReadable()) {
        throw TailorFault(resolvedPath, "the file cannot be read", "check its path and permissions");
    }
    const rust::Vec<tailor::Argument> all = Arguments(arguments);
    return tailor::read_document(TailorStr(resolvedPath), text.GetBytes(), {all.data(), all.size()});
}

std::string TailorGetSource(const tailor::Document &document, const std::string &resolvedPath)
{
    const std::string source(document.source());
    const std::string packaged = InPackage(source, resolvedPath);
    return packaged.empty() ? ArGetResolver().CreateIdentifier(source, ArResolvedPath(resolvedPath)) : packaged;
}

TailorFlattenedSource::TailorFlattenedSource(const std::string &path, const std::string &source, bool reload)
{
    const ArResolverContext context = Context(source);
    const ArResolverContextBinder binder(context);
    const TailorSourceLayers layers(path, source, reload);
    if (ArGetResolver().Resolve(source).empty()) {
        throw TailorFault(
            path, "its source " + source + " cannot be found", "\"source\" is relative to the .tailor file");
    }
    const SdfLayerRefPtr flattened = Flatten(path, source, context);
    const TailorPostedErrors posted;
    const TailorScratchFile file("source.usdc");
    if (!SdfFileFormat::FindById(TfToken("usdc"))->WriteToFile(*flattened, file.GetPath())) {
        throw TailorFault(
            path, "the flattened source cannot be written: " + posted.Take(),
            "check the space and permissions of the temporary folder (TMPDIR)");
    }
    _bytes.emplace(file.GetPath());
}

PXR_NAMESPACE_CLOSE_SCOPE
