#pragma once

#include <pxr/pxr.h>

#include <sstream>
#include <string>

PXR_NAMESPACE_OPEN_SCOPE

template <class T>
std::string TfStringify(const T &value)
{
    std::ostringstream stream;
    stream << value;
    return stream.str();
}

PXR_NAMESPACE_CLOSE_SCOPE
