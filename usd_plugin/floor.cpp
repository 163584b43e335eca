// Two symbols for the Python package. Newer compilers refer to them; glibc 2.28 and the C++ library of GCC 8, with which the
// package runs, lack them.

#include <new>

/// Without it, shared pointers ask glibc 2.32 whether there are several threads. They then count as with threads.
extern "C" {
__attribute__((visibility("hidden"))) char __libc_single_threaded = 0;
}

namespace std {

[[noreturn]] __attribute__((visibility("hidden"))) void __throw_bad_array_new_length()
{
    throw bad_array_new_length();
}

} // namespace std
