#pragma once

#include <pxr/usd/ar/asset.h>
#include <pxr/usd/ar/resolvedPath.h>
#include <pxr/usd/ar/resolverContext.h>

#include <memory>
#include <string>

PXR_NAMESPACE_OPEN_SCOPE

class VtValue;

// Its functions are not virtual; those that a studio's resolver overrides are behind them.
class ArResolver {
public:
    ArResolver() = delete;
    std::string CreateIdentifier(const std::string &assetPath, const ArResolvedPath &anchor = ArResolvedPath()) const;
    ArResolvedPath Resolve(const std::string &assetPath) const;
    void BindContext(const ArResolverContext &context, VtValue *bindingData);
    void UnbindContext(const ArResolverContext &context, VtValue *bindingData);
    ArResolverContext CreateDefaultContextForAsset(const std::string &assetPath) const;
    ArResolverContext GetCurrentContext() const;
    std::shared_ptr<ArAsset> OpenAsset(const ArResolvedPath &path) const;
};

ArResolver &ArGetResolver();

PXR_NAMESPACE_CLOSE_SCOPE
