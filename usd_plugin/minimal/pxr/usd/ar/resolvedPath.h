#pragma once

#include <pxr/pxr.h>

#include <string>
#include <utility>

PXR_NAMESPACE_OPEN_SCOPE

class ArResolvedPath {
public:
    ArResolvedPath() = default;
    explicit ArResolvedPath(std::string path) : _path(std::move(path)) {}
    explicit operator bool() const { return !_path.empty(); }
    bool empty() const { return _path.empty(); }
    const std::string &GetPathString() const { return _path; }

private:
    std::string _path;
};

PXR_NAMESPACE_CLOSE_SCOPE
