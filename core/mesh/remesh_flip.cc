#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/mesh/remesh_steps.h"

namespace burin {
namespace {

using OpenMesh::EdgeHandle;
using OpenMesh::HalfedgeHandle;
using OpenMesh::VertexHandle;

constexpr int kMaxPasses = 4;
// Of the wanted length: diagonals that are farther apart are chosen by the surface.
constexpr double kFarApart = 0.2;
// Qualities.
constexpr double kSliver = 0.1;
constexpr double kPoor = 0.3;
constexpr double kGood = 0.5;
constexpr double kLeastGain = 1.02;

class Flipper {
 public:
  Flipper(const RemeshState& state, FlipFor goal) : state_(state), goal_(goal) {}

  bool IsWanted(EdgeHandle edge) const {
    const OpenMesh::TriConnectivity& mesh = state_.half_edges();
    const HalfedgeHandle h = mesh.halfedge_handle(edge, 0);
    const HalfedgeHandle back = mesh.halfedge_handle(edge, 1);
    if (mesh.is_boundary(edge) || state_.IsFixed(edge)) return false;
    const VertexHandle v[4] = {state_.From(h), state_.To(h), state_.Opposite(h),
                               state_.Opposite(back)};
    const RemeshVertex& a = state_[v[0]];
    const RemeshVertex& b = state_[v[1]];
    const RemeshVertex& c = state_[v[2]];
    const RemeshVertex& d = state_[v[3]];
    const FacetFit now = Worse(FitOf(a, b, c), FitOf(b, a, d));
    const FacetFit then = Worse(FitOf(a, d, c), FitOf(d, b, c));
    if (!then.MayReplace(now, 0)) return false;
    const bool better_shape = then.quality > kLeastGain * now.quality;
    const double apart = DiagonalsApart(a, b, c, d) / state_.WantedLength(h);
    if (apart > kFarApart) {
      const double off_now = OffSurface(a, b);
      const double off_then = OffSurface(c, d);
      if (now.quality < kSliver)
        return better_shape && off_then <= off_now + kFarApart * state_.WantedLength(h);
      return off_then < 0.7 * off_now && (then.quality > kPoor || better_shape);
    }
    if (goal_ == FlipFor::kQuality || now.quality < kPoor) return better_shape;
    return then.quality > kGood && SmallerDegreeErrors(v);
  }

 private:
  static FacetFit Worse(const FacetFit& a, const FacetFit& b) {
    return {std::min(a.quality, b.quality), std::min(a.facing, b.facing)};
  }

  // How far the diagonals' middles are apart along the mean normal.
  static double DiagonalsApart(const RemeshVertex& a, const RemeshVertex& b, const RemeshVertex& c,
                               const RemeshVertex& d) {
    const Eigen::Vector3d normal = (b.position - a.position).cross(c.position - d.position);
    const double length = normal.norm();
    if (!(length > 0)) return 0;
    const Eigen::Vector3d offset = 0.5 * (a.position + b.position - c.position - d.position);
    return std::abs(normal.dot(offset)) / length;
  }

  double OffSurface(const RemeshVertex& a, const RemeshVertex& b) const {
    return state_.DistanceToSurface(0.5 * (a.position + b.position), a.facet);
  }

  // Sum of squares, if a-b became c-d.
  bool SmallerDegreeErrors(const VertexHandle (&v)[4]) const {
    const OpenMesh::TriConnectivity& mesh = state_.half_edges();
    int gain = 0;
    for (int k = 0; k < 4; ++k) {
      const int error = static_cast<int>(mesh.valence(v[k])) - (mesh.is_boundary(v[k]) ? 4 : 6);
      const int change = k < 2 ? -1 : 1;
      gain += error * error - (error + change) * (error + change);
    }
    return gain > 0;
  }

  const RemeshState& state_;
  const FlipFor goal_;
};

}  // namespace

int FlipEdges(RemeshState* state, FlipFor goal) {
  OpenMesh::TriConnectivity& mesh = state->half_edges();
  const Flipper flipper(*state, goal);
  int count = 0;
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    int done = 0;
    for (int e = 0; e < static_cast<int>(mesh.n_edges()); ++e) {
      const EdgeHandle edge(e);
      if (!state->IsAlive(edge) || !flipper.IsWanted(edge) || !mesh.is_flip_ok(edge)) continue;
      mesh.flip(edge);
      ++done;
    }
    count += done;
    if (done == 0) break;
  }
  return count;
}

}  // namespace burin
