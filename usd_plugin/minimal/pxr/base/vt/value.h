#pragma once

#include <pxr/pxr.h>

#include <cstdint>
#include <iosfwd>
#include <string>
#include <type_traits>
#include <typeinfo>

PXR_NAMESPACE_OPEN_SCOPE

class VtValue {
public:
    VtValue() : _info(0) {}
    // A copy would need the type's table of functions, which is not declared here.
    VtValue(const VtValue &) = delete;
    VtValue &operator=(const VtValue &) = delete;
    ~VtValue(); // exported as a weak symbol
    bool IsEmpty() const { return _info == 0; }
    const std::type_info &GetTypeid() const;
    const std::type_info &GetElementTypeid() const;
    std::string GetTypeName() const;
    bool operator==(const VtValue &other) const; // exported as a weak symbol
    bool operator!=(const VtValue &other) const { return !(*this == other); }

    // Arithmetic types only: they are kept in place, which the low bits of `_info` say.
    template <class T>
    bool IsHolding() const
    {
        static_assert(std::is_arithmetic_v<T>, "other types are read through operator<<");
        return (_info & 7) == 3 && GetTypeid() == typeid(T);
    }
    template <class T>
    const T &UncheckedGet() const
    {
        return *reinterpret_cast<const T *>(_storage);
    }

private:
    alignas(8) unsigned char _storage[8];
    uintptr_t _info;
};
static_assert(sizeof(VtValue) == 16);

std::ostream &operator<<(std::ostream &stream, const VtValue &value);

PXR_NAMESPACE_CLOSE_SCOPE
