#pragma once

#include <pxr/pxr.h>
#include <pxr/base/tf/errorMark.h>

#include <stdexcept>
#include <string>

PXR_NAMESPACE_OPEN_SCOPE

/// What is wrong with a `.tailor` file; becomes one error of OpenUSD.
class TailorFault : public std::runtime_error {
public:
    /// `hint` is the remedy, or what OpenUSD said; it may be empty.
    TailorFault(const std::string &path, const std::string &message, const std::string &hint);
};

/// The errors that OpenUSD posts on this thread while this lives. They go no further: who reads a `.tailor` file shall
/// get one error, with these inside.
class TailorPostedErrors {
public:
    TailorPostedErrors() = default;
    ~TailorPostedErrors();

    /// Their texts, one a line, which are then forgotten.
    std::string Take() const;

private:
    TfErrorMark _mark;
};

PXR_NAMESPACE_CLOSE_SCOPE
