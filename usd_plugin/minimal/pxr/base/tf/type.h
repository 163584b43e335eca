#pragma once

#include <pxr/pxr.h>

#include <memory>
#include <string>
#include <typeinfo>

PXR_NAMESPACE_OPEN_SCOPE

class TfType {
public:
    class FactoryBase {
    public:
        virtual ~FactoryBase();
    };

    static const TfType &FindByName(const std::string &name);
    static std::string GetCanonicalTypeName(const std::type_info &type);
#if TAILOR_WHEEL_SET_FACTORY_BY_VALUE
    void SetFactory(std::unique_ptr<FactoryBase> factory) const;
#else
    void SetFactory(std::unique_ptr<FactoryBase> &&factory) const;
#endif

private:
    struct _TypeInfo;
    _TypeInfo *_info;
};
static_assert(sizeof(TfType) == 8);

PXR_NAMESPACE_CLOSE_SCOPE
