#pragma once

#include <pxr/base/tf/weakBase.h>

PXR_NAMESPACE_OPEN_SCOPE

// Every T that the plugin points to begins with TfRefBase and TfWeakBase. Whether the object has expired is not asked:
// file formats live for ever, and layers are held by reference beside these pointers.
template <class T>
class TfWeakPtr {
public:
    TfWeakPtr() = default;
    TfWeakPtr(const TfRefPtr<T> &pointer) : _rawPtr(get_pointer(pointer))
    {
        if (_rawPtr) {
            auto *bytes = const_cast<char *>(reinterpret_cast<const char *>(_rawPtr));
            auto *base = reinterpret_cast<TfWeakBase *>(bytes + sizeof(TfRefBase));
            _remnant = Tf_Remnant::Register(base->_remnantPtr);
        }
    }
    T *operator->() const { return _rawPtr; }
    T &operator*() const { return *_rawPtr; }
    explicit operator bool() const { return _rawPtr != nullptr; }
    bool operator!() const { return _rawPtr == nullptr; }

private:
    T *_rawPtr = nullptr;
    TfRefPtr<Tf_Remnant> _remnant;
};

PXR_NAMESPACE_CLOSE_SCOPE
