#pragma once

#include "scratch.h"
#include "tailor-usd-plugin/src/lib.rs.h"

#include <pxr/pxr.h>
#include <pxr/usd/ar/asset.h>
#include <pxr/usd/ar/resolvedPath.h>
#include <pxr/usd/sdf/fileFormat.h>

#include <memory>
#include <optional>
#include <string>

PXR_NAMESPACE_OPEN_SCOPE

/// A Rust view of a text, which must outlive it.
inline rust::Str TailorStr(const std::string &text)
{
    return rust::Str(text.data(), text.size());
}

/// True for the path of a `.tailor` file, with or without arguments.
bool TailorIsRecipe(const std::string &path);

/// The text of a `.tailor` file, read through the resolver; empty if it cannot be read.
class TailorRecipeText {
public:
    explicit TailorRecipeText(const ArResolvedPath &path);

    bool IsReadable() const { return bool(_asset); }
    rust::Slice<const uint8_t> GetBytes() const;

private:
    std::shared_ptr<ArAsset> _asset;
    std::shared_ptr<const char> _text;
};

/// Reads a `.tailor` file through the resolver. Throws TailorFault or rust::Error.
rust::Box<tailor::Document>
TailorReadDocument(const std::string &resolvedPath, const SdfFileFormat::FileFormatArguments &arguments);

/// The identifier of the layer that a `.tailor` file names as its source.
std::string TailorGetSource(const tailor::Document &document, const std::string &resolvedPath);

/// The source of a `.tailor` file, composed by OpenUSD and flattened into one crate.
class TailorFlattenedSource {
public:
    /// With `reload`, its layers are read from disk again. Throws TailorFault or std::exception.
    TailorFlattenedSource(const std::string &path, const std::string &source, bool reload);

    rust::Slice<const uint8_t> GetBytes() const { return {_bytes->data(), _bytes->size()}; }

private:
    std::optional<TailorMappedFile> _bytes;
};

PXR_NAMESPACE_CLOSE_SCOPE
