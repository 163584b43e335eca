#include "errors.h"

#include <pxr/base/tf/error.h>

PXR_NAMESPACE_OPEN_SCOPE

TailorFault::TailorFault(const std::string &path, const std::string &message, const std::string &hint)
    : std::runtime_error(path + ": " + message + (hint.empty() ? "" : "\n  hint: " + hint))
{
}

TailorPostedErrors::~TailorPostedErrors()
{
    _mark.Clear();
}

std::string TailorPostedErrors::Take() const
{
    std::string text;
    for (const TfError &error : _mark) {
        // Some texts end in line breaks.
        const std::string &message = error.GetCommentary();
        text += (text.empty() ? "" : "\n    ") + message.substr(0, message.find_last_not_of('\n') + 1);
    }
    _mark.Clear();
    return text;
}

PXR_NAMESPACE_CLOSE_SCOPE
