#pragma once

#include <pxr/base/vt/value.h>
#include <pxr/usd/ar/resolver.h>

PXR_NAMESPACE_OPEN_SCOPE

class ArResolverContextBinder {
public:
    explicit ArResolverContextBinder(const ArResolverContext &context) : _context(context)
    {
        ArGetResolver().BindContext(_context, &_bindingData);
    }
    ~ArResolverContextBinder() { ArGetResolver().UnbindContext(_context, &_bindingData); }
    ArResolverContextBinder(const ArResolverContextBinder &) = delete;
    ArResolverContextBinder &operator=(const ArResolverContextBinder &) = delete;

private:
    ArResolverContext _context;
    VtValue _bindingData;
};

PXR_NAMESPACE_CLOSE_SCOPE
