// Golden data for the subdivision tests, and a bench, both made with Pixar OpenSubdiv.
//
//   golden data DIR       writes DIR/{catmark,loop,bilinear,generated,nonmanifold}.bin
//   golden bench MESH     times OpenSubdiv on a text mesh (see bench.h)
//
// Every mesh is built here, by code. All six rules of face-varying linear interpolation are evaluated
// for each case, at levels 1, 2 and 3.

#include "bench.h"
#include "write.h"

#include <exception>
#include <iostream>
#include <stdexcept>
#include <string>

int main(int argc, char** argv) {
    try {
        std::string const mode = argc > 2 ? argv[1] : "";
        if (mode == "data") golden::data(argv[2]);
        else if (mode == "bench") golden::bench(argv[2]);
        else throw std::runtime_error("usage: golden data DIR | golden bench MESH");
    } catch (std::exception const& e) {
        std::cerr << "golden: " << e.what() << "\n";
        return 1;
    }
    return 0;
}
