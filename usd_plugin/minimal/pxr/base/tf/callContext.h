#pragma once

#include <pxr/pxr.h>

PXR_NAMESPACE_OPEN_SCOPE

class TfCallContext {
public:
    constexpr TfCallContext(const char *file, const char *function, size_t line, const char *prettyFunction)
        : _file(file), _function(function), _line(line), _prettyFunction(prettyFunction), _hidden(false)
    {
    }

private:
    const char *_file;
    const char *_function;
    size_t _line;
    const char *_prettyFunction;
    mutable bool _hidden;
};
static_assert(sizeof(TfCallContext) == 40);

#define TF_CALL_CONTEXT TfCallContext(__FILE__, __func__, __LINE__, __PRETTY_FUNCTION__)

PXR_NAMESPACE_CLOSE_SCOPE
