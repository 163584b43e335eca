/* The C++ in the crate `cxx` starts the standard streams, and uses none of them in the core of the Python package. With these
   in place of libstdc++'s, the core needs no C++ library, so that it runs on every Linux with glibc 2.28. */

#define HIDDEN __attribute__((visibility("hidden")))

/* std::ios_base::Init::Init() and ~Init() */
HIDDEN void _ZNSt8ios_base4InitC1Ev(void *init)
{
    (void)init;
}

HIDDEN void _ZNSt8ios_base4InitD1Ev(void *init)
{
    (void)init;
}
