#pragma once

#include <pxr/base/tf/refPtr.h>

PXR_NAMESPACE_OPEN_SCOPE

// Outlives an object, for its weak pointers.
class Tf_Remnant : public TfRefBase {
public:
    static TfRefPtr<Tf_Remnant> Register(std::atomic<Tf_Remnant *> &remnant); // exported as a weak symbol
};

class TfWeakBase {
public:
    TfWeakBase() : _remnantPtr(nullptr) {}

protected:
    ~TfWeakBase(); // exported as a weak symbol

private:
    template <class T>
    friend class TfWeakPtr;
    mutable std::atomic<Tf_Remnant *> _remnantPtr;
};
static_assert(sizeof(TfWeakBase) == 8);

PXR_NAMESPACE_CLOSE_SCOPE
