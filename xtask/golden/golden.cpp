// Golden data for the subdivision tests, made with Pixar OpenSubdiv.
//
//   golden DIR       writes DIR/{catmark,loop,bilinear,generated,nonmanifold}.bin
//
// Every mesh is built here, by code. All six rules of face-varying linear interpolation are evaluated
// for each case, at levels 1, 2 and 3.

#include "write.h"

#include <exception>
#include <iostream>
#include <stdexcept>

int main(int argc, char** argv) {
    try {
        if (argc != 2) throw std::runtime_error("usage: golden DIR");
        golden::data(argv[1]);
    } catch (std::exception const& e) {
        std::cerr << "golden: " << e.what() << "\n";
        return 1;
    }
    return 0;
}
