#pragma once

#include <pxr/pxr.h>

#include <cstdint>
#include <iosfwd>
#include <string>

PXR_NAMESPACE_OPEN_SCOPE

class TfToken {
public:
    explicit TfToken(const std::string &text);
    explicit TfToken(const char *text);
    // A copy would count references inside a structure that is not declared here.
    TfToken(const TfToken &) = delete;
    TfToken &operator=(const TfToken &) = delete;
    ~TfToken(); // exported as a weak symbol
    bool operator==(const std::string &text) const;
    bool operator==(const char *text) const;

private:
    mutable uintptr_t _rep;
};
static_assert(sizeof(TfToken) == 8);

std::ostream &operator<<(std::ostream &stream, const TfToken &token);

PXR_NAMESPACE_CLOSE_SCOPE
