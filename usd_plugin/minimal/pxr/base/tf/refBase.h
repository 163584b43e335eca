#pragma once

#include <pxr/pxr.h>

#include <atomic>

PXR_NAMESPACE_OPEN_SCOPE

class TfRefBase {
public:
    TfRefBase() : _refCount(1) {}

protected:
    virtual ~TfRefBase();

private:
    template <class T>
    friend class TfRefPtr;
    friend class Tf_RefPtr_UniqueChangedCounter;
    // Negative where a listener wants to know when the count becomes or leaves one.
    mutable std::atomic_int _refCount;
};
static_assert(sizeof(TfRefBase) == 16);

class Tf_RefPtr_UniqueChangedCounter {
public:
    static void AddRef(const TfRefBase *object)
    {
        const int count = object->_refCount.load(std::memory_order_relaxed);
        if (count < 0) {
            _AddRefMaybeLocked(object, count);
        } else {
            object->_refCount.fetch_add(1, std::memory_order_relaxed);
        }
    }
    // Whether that was the last one.
    static bool RemoveRef(const TfRefBase *object)
    {
        const int count = object->_refCount.load(std::memory_order_relaxed);
        if (count < 0) {
            return _RemoveRefMaybeLocked(object, count);
        }
        return object->_refCount.fetch_sub(1, std::memory_order_release) == 1;
    }

private:
    static void _AddRefMaybeLocked(const TfRefBase *object, int count);
    static bool _RemoveRefMaybeLocked(const TfRefBase *object, int count);
};

PXR_NAMESPACE_CLOSE_SCOPE
