#include "fileFormat.h"

#include "arguments.h"
#include "errors.h"
#include "scratch.h"
#include "source.h"
#include "sourceLayers.h"

#include "rust/cxx.h"

#include <pxr/base/tf/diagnostic.h>
#include <pxr/base/tf/registryManager.h>
#include <pxr/base/tf/token.h>
#include <pxr/base/tf/type.h>
#include <pxr/usd/sdf/layer.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>

PXR_NAMESPACE_OPEN_SCOPE

TF_REGISTRY_FUNCTION(TfType)
{
    SDF_DEFINE_FILE_FORMAT(TailorFileFormat, SdfFileFormat);
}

namespace {

/// Prints one line of timings for each read, if USDTAILOR_DEBUG is 1.
class DebugLine {
public:
    /// Milliseconds since the last call or the construction.
    double Lap()
    {
        const Clock::time_point now = Clock::now();
        const double milliseconds = std::chrono::duration<double, std::milli>(now - _last).count();
        _last = now;
        return milliseconds;
    }
    static void Print(const SdfLayer &layer, double compose, double rust, double fill)
    {
        static const bool wanted = [] {
            const char *value = std::getenv("USDTAILOR_DEBUG");
            return value && std::string(value) == "1";
        }();
        if (wanted) {
            std::fprintf(
                stderr, "usdtailor: read %s: compose %.1f ms, generate %.1f ms, fill %.1f ms\n",
                layer.GetIdentifier().c_str(), compose, rust, fill);
        }
    }

private:
    using Clock = std::chrono::steady_clock;
    Clock::time_point _last = Clock::now();
};

void Fill(SdfLayer *layer, const rust::Vec<uint8_t> &bytes, const std::string &path)
{
    const TailorPostedErrors posted;
    const TailorMemoryFile file(bytes.data(), bytes.size());
    // Detached: the layer must not depend on the file, which is deleted next. The content is replaced as a whole.
    const auto usdc = SdfFileFormat::FindById(TfToken("usdc"));
    if (!usdc || !usdc->ReadDetached(layer, file.GetPath(), false)) {
        throw TailorFault(path, "internal error: the layer cannot be filled; please report it", posted.Take());
    }
}

void ReadLayer(SdfLayer *layer, const std::string &path, bool metadataOnly)
{
    DebugLine time;
    const rust::Box<tailor::Document> document = TailorReadDocument(path, layer->GetFileFormatArguments());
    // A layer with content is being reloaded.
    const TailorFlattenedSource source(path, TailorGetSource(*document, path), !layer->IsEmpty());
    const double compose = time.Lap();
    const tailor::Generated generated = tailor::generate(*document, source.GetBytes(), metadataOnly);
    const double rust = time.Lap();
    Fill(layer, generated.layer, path);
    DebugLine::Print(*layer, compose, rust, time.Lap());
    for (const rust::String &warning : generated.warnings) {
        TF_WARN("%s: %s", path.c_str(), std::string(warning).c_str());
    }
}

SdfFileFormatConstPtr Text()
{
    return SdfFileFormat::FindById(TfToken("usda"));
}

} // namespace

TailorFileFormat::TailorFileFormat()
    : SdfFileFormat(TfToken("tailor"), TfToken("1.0"), TfToken("usd"), "tailor")
{
}

TailorFileFormat::~TailorFileFormat() = default;

bool TailorFileFormat::CanRead(const std::string &path) const
{
    return TailorIsRecipe(path);
}

bool TailorFileFormat::Read(SdfLayer *layer, const std::string &resolvedPath, bool metadataOnly) const
{
    // An exception that leaves this function would end the host program during composition.
    try {
        ReadLayer(layer, resolvedPath, metadataOnly);
        return true;
    } catch (const TailorFault &fault) {
        TF_RUNTIME_ERROR("%s", fault.what());
    } catch (const rust::Error &fault) {
        TF_RUNTIME_ERROR("%s", fault.what());
    } catch (const std::exception &fault) {
        TF_RUNTIME_ERROR("%s: %s", resolvedPath.c_str(), fault.what());
    } catch (...) {
        TF_RUNTIME_ERROR("%s: internal error: unknown exception; please report it", resolvedPath.c_str());
    }
    return false;
}

std::set<std::string> TailorFileFormat::GetExternalAssetDependencies(const SdfLayer &layer) const
{
    return TailorGetRememberedLayers(layer.GetResolvedPath().GetPathString());
}

bool TailorFileFormat::WriteToString(const SdfLayer &layer, std::string *text, const std::string &comment) const
{
    return Text()->WriteToString(layer, text, comment);
}

bool TailorFileFormat::WriteToStream(const SdfSpecHandle &spec, std::ostream &stream, size_t indent) const
{
    return Text()->WriteToStream(spec, stream, indent);
}

void TailorFileFormat::ComposeFieldsForFileFormatArguments(
    const std::string &assetPath, const PcpDynamicFileFormatContext &context, FileFormatArguments *arguments,
    VtValue *) const
{
    TailorComposeArguments(assetPath, context, arguments);
}

bool TailorFileFormat::CanFieldChangeAffectFileFormatArguments(
    const TfToken &field, const VtValue &oldValue, const VtValue &newValue, const VtValue &) const
{
    return TailorNamesInstances(field) && oldValue != newValue;
}

bool TailorFileFormat::CanAttributeDefaultValueChangeAffectFileFormatArguments(
    const TfToken &attributeName, const VtValue &oldValue, const VtValue &newValue, const VtValue &) const
{
    return TailorIsArgument(attributeName) && oldValue != newValue;
}

PXR_NAMESPACE_CLOSE_SCOPE
