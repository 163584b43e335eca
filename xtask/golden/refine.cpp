#include "refine.h"

#include <opensubdiv/far/primvarRefiner.h>

#include <stdexcept>
#include <utility>

namespace golden {

namespace Sdc = OpenSubdiv::Sdc;

namespace {

template <int N>
std::vector<Value<double, N>> widen(std::vector<std::array<float, N>> const& from) {
    std::vector<Value<double, N>> to(from.size());
    for (std::size_t i = 0; i < from.size(); ++i)
        for (int k = 0; k < N; ++k) to[i].x[k] = from[i][k];
    return to;
}

}  // namespace

Refiner makeRefiner(Description const& description, Scheme scheme, Boundary boundary, bool smooth, int mode) {
    static Sdc::SchemeType const schemes[] = {Sdc::SCHEME_BILINEAR, Sdc::SCHEME_CATMARK, Sdc::SCHEME_LOOP};
    static Sdc::Options::VtxBoundaryInterpolation const boundaries[] = {
        Sdc::Options::VTX_BOUNDARY_NONE, Sdc::Options::VTX_BOUNDARY_EDGE_ONLY,
        Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER};
    static Sdc::Options::FVarLinearInterpolation const modes[] = {
        Sdc::Options::FVAR_LINEAR_NONE,          Sdc::Options::FVAR_LINEAR_CORNERS_ONLY,
        Sdc::Options::FVAR_LINEAR_CORNERS_PLUS1, Sdc::Options::FVAR_LINEAR_CORNERS_PLUS2,
        Sdc::Options::FVAR_LINEAR_BOUNDARIES,    Sdc::Options::FVAR_LINEAR_ALL};
    Sdc::Options options;
    options.SetVtxBoundaryInterpolation(boundaries[boundary]);
    options.SetFVarLinearInterpolation(modes[mode]);
    options.SetTriangleSubdivision(smooth ? Sdc::Options::TRI_SUB_SMOOTH : Sdc::Options::TRI_SUB_CATMARK);
    using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    Refiner refiner(Factory::Create(description.d, Factory::Options(schemes[scheme], options)));
    if (!refiner) throw std::runtime_error("OpenSubdiv rejects the mesh");
    return refiner;
}

Refined refine(Case const& c, Description const& description, int mode) {
    Refined r;
    r.refiner = makeRefiner(description, c.scheme, c.boundary, c.smoothTriangles, mode);
    Far::TopologyRefiner::UniformOptions uniform(kLevels);
    uniform.fullTopologyInLastLevel = true;
    uniform.orderVerticesFromFacesFirst = false;
    r.refiner->RefineUniform(uniform);
    Far::PrimvarRefinerReal<double> const primvars(*r.refiner);
    r.points.push_back(widen<3>(c.mesh.points));
    r.varying.push_back(widen<2>(c.mesh.varying));
    r.uvs.push_back(widen<2>(c.mesh.uvs));
    for (int level = 1; level <= kLevels; ++level) {
        auto const& topology = r.refiner->GetLevel(level);
        std::vector<Point> points(topology.GetNumVertices());
        std::vector<Pair> varying(topology.GetNumVertices()), uvs(topology.GetNumFVarValues(0));
        primvars.Interpolate(level, r.points.back(), points);
        primvars.InterpolateVarying(level, r.varying.back(), varying);
        primvars.InterpolateFaceVarying(level, r.uvs.back(), uvs);
        r.points.push_back(std::move(points));
        r.varying.push_back(std::move(varying));
        r.uvs.push_back(std::move(uvs));
    }
    return r;
}

}  // namespace golden
