#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/mesh/remesh_steps.h"
#include "core/support/parallel.h"

namespace burin {
namespace {

using OpenMesh::EdgeHandle;
using OpenMesh::HalfedgeHandle;
using OpenMesh::VertexHandle;

constexpr int kGrain = 2048;
constexpr int kMaxPasses = 6;
// Of the wanted length: diagonals that are farther apart are chosen by the surface.
constexpr double kFarApart = 0.2;
// Qualities.
constexpr double kSliver = 0.1;
constexpr double kPoor = 0.3;
constexpr double kGood = 0.5;
constexpr double kLeastGain = 1.02;

class Flipper {
 public:
  Flipper(RemeshState* state, FlipFor goal)
      : state_(*state), mesh_(state->half_edges()), goal_(goal) {
    if (goal == FlipFor::kQuality) return;
    degree_error_.resize(mesh_.n_vertices());
    ParallelFor(static_cast<int>(mesh_.n_vertices()), kGrain, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        const VertexHandle v(i);
        if (!state_.IsAlive(v)) continue;
        degree_error_[i] = static_cast<int>(mesh_.valence(v)) - (mesh_.is_boundary(v) ? 4 : 6);
      }
    });
  }

  int Run() {
    // What is wanted of the surface as it is, in parallel; then again in order, for each flip changes what its
    // neighbours want.
    std::vector<char> wanted(mesh_.n_edges(), 0);
    ParallelFor(static_cast<int>(mesh_.n_edges()), kGrain, [&](int begin, int end) {
      for (int e = begin; e < end; ++e) {
        wanted[e] = static_cast<char>(state_.IsAlive(EdgeHandle(e)) && IsWanted(EdgeHandle(e)));
      }
    });
    int count = 0;
    for (int pass = 0; pass < kMaxPasses; ++pass) {
      int done = 0;
      for (int e = 0; e < static_cast<int>(wanted.size()); ++e) {
        if (wanted[e] == 0) continue;
        wanted[e] = 0;
        const EdgeHandle edge(e);
        if (!IsWanted(edge) || !mesh_.is_flip_ok(edge)) continue;
        Flip(edge);
        ++done;
        for (int side = 0; side < 2; ++side) {
          const HalfedgeHandle h = mesh_.halfedge_handle(edge, side);
          const HalfedgeHandle next = mesh_.next_halfedge_handle(h);
          wanted[mesh_.edge_handle(next).idx()] = 1;
          wanted[mesh_.edge_handle(mesh_.next_halfedge_handle(next)).idx()] = 1;
        }
      }
      count += done;
      if (done == 0) break;
    }
    return count;
  }

 private:
  struct Quad {  // a-b is the diagonal, c left of it
    VertexHandle a, b, c, d;
  };

  Quad QuadOf(EdgeHandle edge) const {
    const HalfedgeHandle h = mesh_.halfedge_handle(edge, 0);
    return {state_.From(h), state_.To(h), state_.Opposite(h),
            state_.Opposite(mesh_.halfedge_handle(edge, 1))};
  }

  void Flip(EdgeHandle edge) {
    if (goal_ == FlipFor::kValence) {
      const Quad quad = QuadOf(edge);
      --degree_error_[quad.a.idx()];
      --degree_error_[quad.b.idx()];
      ++degree_error_[quad.c.idx()];
      ++degree_error_[quad.d.idx()];
    }
    mesh_.flip(edge);
  }

  bool IsWanted(EdgeHandle edge) const {
    if (mesh_.is_boundary(edge) || state_.IsFixed(edge)) return false;
    const Quad quad = QuadOf(edge);
    const RemeshVertex& a = state_[quad.a];
    const RemeshVertex& b = state_[quad.b];
    const RemeshVertex& c = state_[quad.c];
    const RemeshVertex& d = state_[quad.d];
    if (quad.c == quad.d) return false;
    if (!state_.MayJoin(quad.c, quad.d)) return false;
    const double quality = std::min(Quality(a, b, c), Quality(b, a, d));
    const double new_quality = std::min(Quality(a, d, c), Quality(d, b, c));
    const bool better_shape = new_quality > kLeastGain * quality;
    const double wanted_length = 0.5 * (a.length + b.length);
    bool wanted = better_shape;
    if (DiagonalsApart(a, b, c, d) > kFarApart * wanted_length) {
      const double off = OffSurface(a, b);
      const double new_off = OffSurface(c, d);
      wanted = quality < kSliver ? better_shape && new_off <= off + kFarApart * wanted_length
                                 : new_off < 0.7 * off && (new_quality > kPoor || better_shape);
    } else if (goal_ == FlipFor::kValence && quality >= kPoor) {
      wanted = new_quality > kGood && SmallerDegreeErrors(quad);
    }
    if (!wanted) return false;
    const double facing = std::min(FitOf(a, b, c).facing, FitOf(b, a, d).facing);
    const double new_facing = std::min(FitOf(a, d, c).facing, FitOf(d, b, c).facing);
    return new_facing >= std::min(FacetFit::kLeastFacing, facing);
  }

  static double Quality(const RemeshVertex& a, const RemeshVertex& b, const RemeshVertex& c) {
    return FacetQuality(a.position, b.position, c.position);
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
    return state_.DistanceToSurface(0.5 * (a.position + b.position), a);
  }

  // Sum of squares, if a-b became c-d.
  bool SmallerDegreeErrors(const Quad& quad) const {
    const int errors = degree_error_[quad.a.idx()] + degree_error_[quad.b.idx()] -
                       degree_error_[quad.c.idx()] - degree_error_[quad.d.idx()];
    return errors > 2;
  }

  RemeshState& state_;
  OpenMesh::TriConnectivity& mesh_;
  const FlipFor goal_;
  std::vector<int> degree_error_;  // by vertex: its degree less the best
};

}  // namespace

int FlipEdges(RemeshState* state, FlipFor goal) { return Flipper(state, goal).Run(); }

}  // namespace burin
