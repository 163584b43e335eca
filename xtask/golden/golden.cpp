// Golden data for the subdivision tests, made with Pixar OpenSubdiv.
//
//   golden DIR GARMENTS       writes DIR/{catmark,loop,bilinear,generated,nonmanifold,garments}.bin
//
// Meshes are built here, by code, but for those of the file GARMENTS, which garments.py writes. All six rules of face-varying linear interpolation are evaluated
// for each case, at levels 1, 2 and 3.

#include "write.h"

#include <exception>
#include <iostream>
#include <stdexcept>

int main(int argc, char** argv) {
    try {
        if (argc != 3) throw std::runtime_error("usage: golden DIR GARMENTS");
        golden::data(argv[1], argv[2]);
    } catch (std::exception const& e) {
        std::cerr << "golden: " << e.what() << "\n";
        return 1;
    }
    return 0;
}
