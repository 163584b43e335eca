#pragma once

#include <pxr/pxr.h>

// Runs when the library is loaded, which is after its plugInfo.json has declared the type.
#define TF_REGISTRY_FUNCTION(KEY)                                                                                      \
    static void _TailorRegister##KEY() __attribute__((constructor));                                                   \
    static void _TailorRegister##KEY()
