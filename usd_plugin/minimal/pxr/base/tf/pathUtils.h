#pragma once

#include <pxr/pxr.h>

#include <string>

PXR_NAMESPACE_OPEN_SCOPE

std::string TfGetPathName(const std::string &fileName);
bool TfIsRelativePath(const std::string &path);
std::string TfNormPath(const std::string &path, bool stripDriveSpecifier = false);

PXR_NAMESPACE_CLOSE_SCOPE
