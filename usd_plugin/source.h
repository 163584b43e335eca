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

/// A text as Rust takes it, as long as it is there.
inline rust::Str TailorStr(const std::string &text)
{
    return rust::Str(text.data(), text.size());
}

/// Whether a path, with or without arguments, is that of a `.tailor` file.
bool TailorIsRecipe(const std::string &path);

/// The text of a `.tailor` file through the resolver; empty where it cannot be read.
class TailorRecipeText {
public:
    explicit TailorRecipeText(const ArResolvedPath &path);

    bool IsReadable() const { return bool(_asset); }
    rust::Slice<const uint8_t> GetBytes() const;

private:
    std::shared_ptr<ArAsset> _asset;
    std::shared_ptr<const char> _text;
};

/// Reads a `.tailor` file through the resolver; throws what is wrong with it.
rust::Box<tailor::Document>
TailorReadDocument(const std::string &resolvedPath, const SdfFileFormat::FileFormatArguments &arguments);

/// The identifier of the layer that a `.tailor` file names as its source.
std::string TailorGetSource(const tailor::Document &document, const std::string &resolvedPath);

/// The source of a `.tailor` file, composed by OpenUSD and flattened into one crate.
class TailorFlattenedSource {
public:
    /// `reload` takes its layers from disk again. Throws what is wrong with the source.
    TailorFlattenedSource(const std::string &path, const std::string &source, bool reload);

    rust::Slice<const uint8_t> GetBytes() const { return {_bytes->data(), _bytes->size()}; }

private:
    std::optional<TailorMappedFile> _bytes;
};

PXR_NAMESPACE_CLOSE_SCOPE
