// The garments in examples/, as garments.py hands them over: the fields of a case without slots and levels.

#include "cases.h"

#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace golden {

namespace {

class Reader {
public:
    explicit Reader(std::filesystem::path const& path) {
        std::ifstream file(path, std::ios::binary);
        if (!file) throw std::runtime_error("cannot read " + path.string());
        bytes_.assign(std::istreambuf_iterator<char>(file), {});
    }
    bool atEnd() const { return at_ == bytes_.size(); }
    int u8() { return static_cast<int>(number(1)); }
    int u16() { return static_cast<int>(number(2)); }
    int u32() { return static_cast<int>(number(4)); }
    float f32() {
        std::uint32_t const bits = number(4);
        float f;
        std::memcpy(&f, &bits, 4);
        return f;
    }
    std::string str() {
        std::string s(u16(), ' ');
        for (char& c : s) c = static_cast<char>(u8());
        return s;
    }

private:
    std::uint32_t number(int size) {
        std::uint32_t n = 0;
        for (int i = 0; i < size; ++i) n |= std::uint32_t(static_cast<unsigned char>(bytes_.at(at_++))) << (8 * i);
        return n;
    }

    std::string bytes_;
    std::size_t at_ = 0;
};

}  // namespace

Cases garmentCases(std::filesystem::path const& path) {
    Reader in(path);
    Cases cases;
    while (!in.atEnd()) {
        // As many samples of the first level as keep the file small: the garments are large, and few.
        Case c{in.str(), {}, Scheme(in.u8()), Boundary(in.u8()), in.u8() != 0, {300, 60, 20}};
        Mesh& m = c.mesh;
        for (int n = in.u32(); n > 0; --n) {
            m.points.push_back({in.f32(), in.f32(), in.f32()});
            m.varying.push_back({in.f32(), in.f32()});
        }
        for (int n = in.u32(); n > 0; --n) m.counts.push_back(in.u16());
        for (int n = in.u32(); n > 0; --n) m.indices.push_back(in.u16());
        for (int n = in.u32(); n > 0; --n) m.creases.push_back({in.u16(), in.u16(), in.f32()});
        for (int n = in.u32(); n > 0; --n) m.corners.push_back({in.u16(), in.f32()});
        for (int n = in.u32(); n > 0; --n) m.holes.push_back(in.u16());
        for (int n = in.u32(); n > 0; --n) m.uvs.push_back({in.f32(), in.f32()});
        for (std::size_t i = 0; i < m.indices.size(); ++i) m.uvIndices.push_back(in.u16());
        cases.push_back(std::move(c));
    }
    return cases;
}

}  // namespace golden
