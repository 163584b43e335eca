#pragma once

#include <pxr/base/tf/diagnosticMgr.h>

#include <iterator>

PXR_NAMESPACE_OPEN_SCOPE

class TfErrorMark {
public:
    using Iterator = TfDiagnosticMgr::ErrorIterator;

    TfErrorMark();
    ~TfErrorMark();
    TfErrorMark(const TfErrorMark &) = delete;
    TfErrorMark &operator=(const TfErrorMark &) = delete;

    Iterator begin() const { return _Begin(nullptr); }
    // The errors since the mark are the last of the list.
    Iterator end() const
    {
        size_t errors = 0;
        const Iterator first = _Begin(&errors);
        return std::next(first, static_cast<std::ptrdiff_t>(errors));
    }
    bool IsClean() const { return begin() == end(); }
    bool Clear() const
    {
        const bool any = !IsClean();
        if (any) {
            TfDiagnosticMgr::GetInstance().EraseRange(begin(), end());
        }
        return any;
    }

private:
    Iterator _Begin(size_t *errors) const { return TfDiagnosticMgr::GetInstance()._GetErrorMarkBegin(_mark, errors); }

    size_t _mark;
    // 8 bytes long until 26.5, 16 since then: room for what the constructor may write.
    void *_room[7];
};

PXR_NAMESPACE_CLOSE_SCOPE
