#pragma once

#include <pxr/base/tf/error.h>

#include <list>

PXR_NAMESPACE_OPEN_SCOPE

template <class T>
class TfSingleton {
public:
    static T &GetInstance(); // exported as a weak symbol
};

class TfDiagnosticMgr {
public:
    using ErrorIterator = std::_List_iterator<TfError>;
    static TfDiagnosticMgr &GetInstance() { return TfSingleton<TfDiagnosticMgr>::GetInstance(); }
    ErrorIterator EraseRange(ErrorIterator first, ErrorIterator last);
    TfDiagnosticMgr() = delete;

private:
    friend class TfErrorMark;
    ErrorIterator _GetErrorMarkBegin(size_t mark, size_t *errors);
};

PXR_NAMESPACE_CLOSE_SCOPE
