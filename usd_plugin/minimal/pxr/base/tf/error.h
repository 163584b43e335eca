#pragma once

#include <pxr/base/tf/callContext.h>

#include <string>

PXR_NAMESPACE_OPEN_SCOPE

// Only seen inside the list of errors, so the members after these two and the size do not matter.
class TfError {
public:
    TfError(const TfError &) = delete;
    TfError &operator=(const TfError &) = delete;
    const std::string &GetCommentary() const { return _commentary; }

private:
    TfError();
    ~TfError();
    TfCallContext _context;
    std::string _commentary;
};

PXR_NAMESPACE_CLOSE_SCOPE
