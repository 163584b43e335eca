#pragma once

#include <pxr/pxr.h>
#include <pxr/base/tf/errorMark.h>

#include <stdexcept>
#include <string>

PXR_NAMESPACE_OPEN_SCOPE

/// An error in a `.tailor` file or its source; it is posted as one OpenUSD error.
class TailorFault : public std::runtime_error {
public:
    /// `hint` is the remedy or OpenUSD's message; it may be empty.
    TailorFault(const std::string &path, const std::string &message, const std::string &hint);
};

/// Captures the errors that OpenUSD posts on this thread during its lifetime. Their texts become part of the one error
/// that a reader of a `.tailor` file gets.
class TailorPostedErrors {
public:
    TailorPostedErrors() = default;
    ~TailorPostedErrors();

    /// Returns their texts, one per line, and clears them.
    std::string Take() const;

private:
    TfErrorMark _mark;
};

PXR_NAMESPACE_CLOSE_SCOPE
