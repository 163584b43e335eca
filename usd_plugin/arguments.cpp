#include "arguments.h"

#include "source.h"
#include "tailor-usd-plugin/src/lib.rs.h"

#include <pxr/base/tf/diagnostic.h>
#include <pxr/base/tf/stringUtils.h>
#include <pxr/base/tf/token.h>
#include <pxr/base/vt/value.h>
#include <pxr/usd/ar/resolver.h>
#include <pxr/usd/pcp/dynamicFileFormatContext.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

constexpr const char *AppliedSchemas = "apiSchemas";
/// Separates a layer's path from its arguments in an asset path.
constexpr std::string_view ArgumentsDelimiter = ":SDF_FORMAT_ARGS:";

/// The prim's applied schemas in all layers, as OpenUSD prints them.
std::string Schemas(const PcpDynamicFileFormatContext &context)
{
    std::vector<VtValue> values;
    std::string schemas;
    if (context.ComposeValueStack(TfToken(AppliedSchemas), &values)) {
        for (const VtValue &value : values) {
            schemas += TfStringify(value) + "\n";
        }
    }
    return schemas;
}

/// The attributes to compose. They depend on the instances that the payload names.
rust::Vec<tailor::Field> Fields(const std::string &assetPath, const PcpDynamicFileFormatContext &context)
{
    const size_t end = assetPath.find(ArgumentsDelimiter);
    const std::string arguments =
        end == std::string::npos ? std::string() : assetPath.substr(end + ArgumentsDelimiter.size());
    // An unreadable file names no instances; the error is reported when the payload is opened.
    const TailorRecipeText text(ArGetResolver().Resolve(assetPath.substr(0, end)));
    const std::string schemas = Schemas(context);
    return tailor::fields(text.GetBytes(), TailorStr(schemas), TailorStr(arguments));
}

template <class T>
std::string Number(T number)
{
    return std::to_string(number);
}

std::string Number(float number)
{
    return std::string(tailor::float_text(number));
}

std::string Number(double number)
{
    return std::string(tailor::double_text(number));
}

template <class T>
bool AddNumber(const VtValue &value, std::optional<std::string> *text)
{
    const bool holds = value.IsHolding<T>();
    if (holds) {
        *text = Number(value.UncheckedGet<T>());
    }
    return holds;
}

/// Converts `[a, b]`, OpenUSD's form of an array, to `a,b`.
std::string List(const std::string &printed)
{
    std::string list;
    for (size_t at = 1; at + 1 < printed.size(); ++at) {
        if (printed[at] != ' ') {
            list += printed[at];
        }
    }
    return list;
}

/// Converts `@path@`, OpenUSD's form of an asset path, to the path. Versions of OpenUSD keep its parts at other places.
std::string AssetPath(const std::string &printed)
{
    const size_t start = printed.find_first_not_of('@');
    const size_t end = printed.find_last_not_of('@');
    return start == std::string::npos ? std::string() : printed.substr(start, end - start + 1);
}

/// True for an empty value and for a value block.
bool IsNothing(const VtValue &value)
{
    return value.IsEmpty() || value.GetTypeName() == "SdfValueBlock";
}

bool IsText(const std::type_info &type)
{
    return type == typeid(TfToken) || type == typeid(std::string);
}

std::optional<std::string> Text(const VtValue &value)
{
    std::optional<std::string> text;
    if (value.IsHolding<bool>()) {
        text = value.UncheckedGet<bool>() ? "true" : "false";
    } else if (
        AddNumber<float>(value, &text) || AddNumber<double>(value, &text) || AddNumber<int>(value, &text) ||
        AddNumber<unsigned int>(value, &text) || AddNumber<int64_t>(value, &text)) {
    } else if (value.GetTypeName() == "SdfAssetPath") {
        text = AssetPath(TfStringify(value));
    } else if (IsText(value.GetTypeid())) {
        text = TfStringify(value);
    } else if (IsText(value.GetElementTypeid())) {
        text = List(TfStringify(value));
    }
    return text;
}

} // namespace

void TailorComposeArguments(
    const std::string &assetPath, const PcpDynamicFileFormatContext &context,
    SdfFileFormat::FileFormatArguments *arguments)
{
    for (const tailor::Field &field : Fields(assetPath, context)) {
        const std::string attribute(field.attribute);
        VtValue value;
        if (!context.ComposeAttributeDefaultValue(TfToken(attribute), &value) || IsNothing(value)) {
            continue;
        }
        if (const std::optional<std::string> text = Text(value)) {
            (*arguments)[std::string(field.argument)] = *text;
        } else {
            TF_WARN(
                "%s: %s has type %s, which no option has; it is ignored", assetPath.c_str(), attribute.c_str(),
                value.GetTypeName().c_str());
        }
    }
}

bool TailorIsArgument(const TfToken &attributeName)
{
    const std::string name = TfStringify(attributeName);
    return tailor::is_field(TailorStr(name));
}

bool TailorNamesInstances(const TfToken &field)
{
    return field == AppliedSchemas;
}

PXR_NAMESPACE_CLOSE_SCOPE
