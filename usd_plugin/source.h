#pragma once

#include "scratch.h"
#include "tailor-usd-plugin/src/lib.rs.h"

#include <pxr/pxr.h>
#include <pxr/usd/sdf/fileFormat.h>

#include <optional>
#include <string>

PXR_NAMESPACE_OPEN_SCOPE

/// Whether a path, with or without arguments, is that of a `.tailor` file.
bool TailorIsRecipe(const std::string &path);

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
