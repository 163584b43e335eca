#include "arguments.h"

#include "tailor-usd-plugin/src/lib.rs.h"

#include <pxr/base/tf/diagnostic.h>
#include <pxr/base/tf/stringUtils.h>
#include <pxr/base/tf/token.h>
#include <pxr/base/vt/value.h>
#include <pxr/usd/pcp/dynamicFileFormatContext.h>

#include <charconv>
#include <cstdint>
#include <optional>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

struct Field {
    std::string attribute;
    std::string argument;
};

const std::vector<Field> &Fields()
{
    static const std::vector<Field> fields = [] {
        std::vector<Field> all;
        for (const tailor::Field &field : tailor::fields()) {
            all.push_back({std::string(field.attribute), std::string(field.argument)});
        }
        return all;
    }();
    return fields;
}

/// The shortest text that reads as the same number again: a layer's identity is the text of its arguments.
template <class T>
std::string Number(T number)
{
    char text[64];
    return std::string(text, std::to_chars(text, text + sizeof(text), number).ptr);
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

/// `[a, b]`, as OpenUSD prints arrays, as `a,b`.
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

/// Whether there is no value, or one that takes away weaker ones.
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
    for (const Field &field : Fields()) {
        VtValue value;
        if (!context.ComposeAttributeDefaultValue(TfToken(field.attribute), &value) || IsNothing(value)) {
            continue;
        }
        if (const std::optional<std::string> text = Text(value)) {
            (*arguments)[field.argument] = *text;
        } else {
            TF_WARN(
                "%s: %s is a %s, which no option is; it is left out", assetPath.c_str(), field.attribute.c_str(),
                value.GetTypeName().c_str());
        }
    }
}

bool TailorIsArgument(const TfToken &attributeName)
{
    for (const Field &field : Fields()) {
        if (attributeName == field.attribute) {
            return true;
        }
    }
    return false;
}

PXR_NAMESPACE_CLOSE_SCOPE
