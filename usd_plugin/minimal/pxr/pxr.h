// Stands in for OpenUSD's headers where only a usd-core wheel is installed. Each file declares just what the plugin
// uses, in the layout of the wheels; `cargo xtask plugin` compares the declarations with the wheel before it builds.
// tailorWheel.h is generated from the wheel: its namespace, version and the C++ library's string ABI.
#pragma once

#include "tailorWheel.h"

#include <cstddef>

#if !defined(__x86_64__) || !defined(__linux__)
#error "the declarations are those of x86-64 Linux; build against an OpenUSD SDK here"
#endif
#if _GLIBCXX_USE_CXX11_ABI != TAILOR_WHEEL_CXX11_ABI
#error "_GLIBCXX_USE_CXX11_ABI is not that of the wheel"
#endif

#define PXR_NS pxr
#define PXR_NAMESPACE_OPEN_SCOPE namespace PXR_INTERNAL_NS {
#define PXR_NAMESPACE_CLOSE_SCOPE }
#define PXR_NAMESPACE_USING_DIRECTIVE using namespace PXR_NS;

namespace PXR_INTERNAL_NS {}
namespace pxr {
using namespace PXR_INTERNAL_NS;
}
