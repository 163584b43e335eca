#pragma once

#include <pxr/pxr.h>

#include <memory>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

class ArResolverContext {
public:
    bool IsEmpty() const { return _contexts.empty(); }

private:
    struct _Untyped;
    std::vector<std::shared_ptr<_Untyped>> _contexts;
};

PXR_NAMESPACE_CLOSE_SCOPE
