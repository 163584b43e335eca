#pragma once

#include <pxr/base/tf/refBase.h>

#include <cstddef>
#include <utility>

PXR_NAMESPACE_OPEN_SCOPE

// Every T that the plugin holds has TfRefBase as its first base, at its own address; most are not defined here.
template <class T>
class TfRefPtr {
public:
    TfRefPtr() = default;
    TfRefPtr(std::nullptr_t) {}
    TfRefPtr(const TfRefPtr &other) : _refBase(other._refBase)
    {
        if (_refBase) {
            Tf_RefPtr_UniqueChangedCounter::AddRef(_refBase);
        }
    }
    TfRefPtr(TfRefPtr &&other) noexcept : _refBase(std::exchange(other._refBase, nullptr)) {}
    TfRefPtr &operator=(TfRefPtr other) noexcept
    {
        std::swap(_refBase, other._refBase);
        return *this;
    }
    ~TfRefPtr()
    {
        if (_refBase && Tf_RefPtr_UniqueChangedCounter::RemoveRef(_refBase)) {
            std::atomic_thread_fence(std::memory_order_acquire);
            delete _refBase;
        }
    }
    T *operator->() const { return get_pointer(*this); }
    T &operator*() const { return *get_pointer(*this); }
    explicit operator bool() const { return _refBase != nullptr; }
    bool operator!() const { return _refBase == nullptr; }

private:
    template <class U>
    friend TfRefPtr<U> TfCreateRefPtr(U *object);
    template <class U>
    friend U *get_pointer(const TfRefPtr<U> &pointer);
    const TfRefBase *_refBase = nullptr;
};

// Takes over the reference with which an object is born.
template <class T>
TfRefPtr<T> TfCreateRefPtr(T *object)
{
    TfRefPtr<T> pointer;
    pointer._refBase = reinterpret_cast<const TfRefBase *>(object);
    return pointer;
}

template <class T>
T *get_pointer(const TfRefPtr<T> &pointer)
{
    return reinterpret_cast<T *>(const_cast<TfRefBase *>(pointer._refBase));
}

PXR_NAMESPACE_CLOSE_SCOPE
