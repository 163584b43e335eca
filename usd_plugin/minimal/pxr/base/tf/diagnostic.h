#pragma once

#include <pxr/base/tf/callContext.h>

PXR_NAMESPACE_OPEN_SCOPE

enum TfDiagnosticType : int {
    TF_DIAGNOSTIC_INVALID_TYPE = 0,
    TF_DIAGNOSTIC_CODING_ERROR_TYPE,
    TF_DIAGNOSTIC_FATAL_CODING_ERROR_TYPE,
    TF_DIAGNOSTIC_RUNTIME_ERROR_TYPE,
    TF_DIAGNOSTIC_FATAL_ERROR_TYPE,
    TF_DIAGNOSTIC_NONFATAL_ERROR_TYPE,
    TF_DIAGNOSTIC_WARNING_TYPE,
    TF_DIAGNOSTIC_STATUS_TYPE,
    TF_APPLICATION_EXIT_TYPE,
};

class Tf_DiagnosticLiteHelper {
public:
    constexpr Tf_DiagnosticLiteHelper(const TfCallContext &context, TfDiagnosticType type)
        : _context(context), _type(type)
    {
    }
    void IssueError(const char *format, ...) const __attribute__((format(printf, 2, 3)));
    void IssueWarning(const char *format, ...) const __attribute__((format(printf, 2, 3)));

private:
    TfCallContext _context;
    TfDiagnosticType _type;
};

#define TF_RUNTIME_ERROR Tf_DiagnosticLiteHelper(TF_CALL_CONTEXT, TF_DIAGNOSTIC_RUNTIME_ERROR_TYPE).IssueError
#define TF_WARN Tf_DiagnosticLiteHelper(TF_CALL_CONTEXT, TF_DIAGNOSTIC_WARNING_TYPE).IssueWarning

PXR_NAMESPACE_CLOSE_SCOPE
