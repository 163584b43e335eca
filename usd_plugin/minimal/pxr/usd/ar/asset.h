#pragma once

#include <pxr/pxr.h>

#include <cstdio>
#include <memory>
#include <utility>

PXR_NAMESPACE_OPEN_SCOPE

class ArAsset {
public:
    ArAsset(const ArAsset &) = delete;
    ArAsset &operator=(const ArAsset &) = delete;
    virtual ~ArAsset();
    virtual size_t GetSize() const = 0;
    virtual std::shared_ptr<const char> GetBuffer() const = 0;
    virtual size_t Read(void *buffer, size_t count, size_t offset) const = 0;
    virtual std::pair<FILE *, size_t> GetFileUnsafe() const = 0;
    virtual std::shared_ptr<ArAsset> GetDetachedAsset() const;

protected:
    ArAsset();
};

PXR_NAMESPACE_CLOSE_SCOPE
