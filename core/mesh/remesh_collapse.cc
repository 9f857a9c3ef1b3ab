#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/mesh/remesh_steps.h"

namespace burin {
namespace {

using OpenMesh::EdgeHandle;
using OpenMesh::FaceHandle;
using OpenMesh::HalfedgeHandle;
using OpenMesh::VertexHandle;

constexpr double kTooShort = 4.0 / 5;
constexpr int kMaxPasses = 8;
constexpr double kWorthAPass = 0.1;  // share of the short edges that the pass before could collapse
// A facet that a collapse changes has at least this quality, and turns by no more than this (cosine), unless it was
// worse.
constexpr double kLeastQuality = 0.2;
constexpr double kLeastTurn = 0.7;
constexpr double kNoNormal = 0.05;  // quality of a facet whose normal says nothing
// Of the wanted length: how far a vertex of the border may be off the chord that replaces it; how far a vertex may leave
// the planes of its facets, or else by how much of the way that it goes: across a sharp edge it does not go.
constexpr double kBorderTolerance = 0.08;
constexpr double kSurfaceTolerance = 0.04;
constexpr double kSteep = 0.6;
// The middle of an edge is left for one of its ends where the surface moves by this much more.
constexpr double kClearlyBetter = 2;
constexpr double kNothing = 0.002;  // of the wanted length

class Collapser {
 public:
  Collapser(RemeshState* state, double longest) : state_(*state), longest_(longest) {}

  bool Collapse(EdgeHandle edge) {
    const HalfedgeHandle h = state_.half_edges().halfedge_handle(edge, 0);
    const RemeshVertex& from = state_[state_.From(h)];
    const RemeshVertex& to = state_[state_.To(h)];
    if (!MayGo(h)) return MayGo(Opposite(h)) && CollapseTo(Opposite(h), from);
    if (!MayGo(Opposite(h))) return CollapseTo(h, to);
    if (from.border >= 0) return CollapseTo(h, to) || CollapseTo(Opposite(h), from);
    const RemeshVertex middle = state_.OnSurfaceAt(0.5 * (from.position + to.position), from);
    const double middle_error = Error(h, middle.position);
    const double errors[2] = {Error(h, from.position), Error(h, to.position)};
    const bool prefers_middle = middle_error <= kSurfaceTolerance * state_.WantedLength(h) &&
                                middle_error <= kClearlyBetter * std::min(errors[0], errors[1]) +
                                                    kNothing * state_.WantedLength(h);
    if (prefers_middle && CollapseTo(h, middle)) return true;
    const auto to_end = [&](bool keep_from) {
      return keep_from ? CollapseTo(Opposite(h), from) : CollapseTo(h, to);
    };
    const bool from_first = errors[0] < errors[1];
    return to_end(from_first) || to_end(!from_first) || (!prefers_middle && CollapseTo(h, middle));
  }

 private:
  HalfedgeHandle Opposite(HalfedgeHandle h) const {
    return state_.half_edges().opposite_halfedge_handle(h);
  }

  // The vertex that the half-edge comes from: not fixed, nor a corner or the only hold of a border.
  bool MayGo(HalfedgeHandle h) const {
    const OpenMesh::TriConnectivity& mesh = state_.half_edges();
    const VertexHandle v = state_.From(h);
    if (state_[v].fixed >= 0) return false;
    if (state_[v].border < 0) return true;
    HalfedgeHandle next;  // the other border edge at v, away from v
    if (mesh.is_boundary(h)) {
      next = Opposite(mesh.prev_halfedge_handle(h));
    } else if (mesh.is_boundary(Opposite(h))) {
      next = mesh.next_halfedge_handle(Opposite(h));
    } else {
      return false;
    }
    const Eigen::Vector3d& from = state_.Position(state_.To(h));
    const Eigen::Vector3d chord = state_.Position(state_.To(next)) - from;
    const Eigen::Vector3d offset = state_.Position(v) - from;
    const double squared_length = chord.squaredNorm();
    if (!(squared_length > 0)) return false;
    const double t = std::clamp(chord.dot(offset) / squared_length, 0.0, 1.0);
    return (offset - t * chord).norm() <= kBorderTolerance * state_.WantedLength(h);
  }

  // The largest distance from `position` to the planes of the facets around the end that would move there.
  double Error(HalfedgeHandle h, const Eigen::Vector3d& position) const {
    double error = 0;
    for (const VertexHandle v : {state_.From(h), state_.To(h)}) {
      state_.ForFacets(v, [&](HalfedgeHandle side) {
        const Eigen::Vector3d& at = state_.Position(v);
        const Eigen::Vector3d normal = (state_.Position(state_.To(side)) - at)
                                           .cross(state_.Position(state_.Opposite(side)) - at);
        const double length = normal.norm();
        if (length > 0) error = std::max(error, std::abs(normal.dot(position - at)) / length);
      });
    }
    return error;
  }

  bool KeepsShape(VertexHandle v, VertexHandle other, const RemeshVertex& target) const {
    bool good = true;
    const Eigen::Vector3d move = target.position - state_[v].position;
    const double most = std::max(kSurfaceTolerance * target.length, kSteep * move.norm());
    state_.ForFacets(v, [&](HalfedgeHandle side) {
      const VertexHandle x = state_.To(side);
      const VertexHandle y = state_.Opposite(side);
      if (!good || x == other || y == other) return;
      const RemeshVertex& a = state_[v];
      const RemeshVertex& b = state_[x];
      const RemeshVertex& c = state_[y];
      for (const RemeshVertex* end : {&b, &c}) {
        const double length = (end->position - target.position).norm();
        if (length > longest_ * 0.5 * (end->length + target.length) &&
            length > (end->position - a.position).norm()) {
          good = false;
          return;
        }
      }
      const Eigen::Vector3d edge = c.position - b.position;
      const Eigen::Vector3d old_normal = edge.cross(a.position - b.position);
      const Eigen::Vector3d new_normal = edge.cross(target.position - b.position);
      const bool turns =
          old_normal.dot(new_normal) < kLeastTurn * old_normal.norm() * new_normal.norm();
      const FacetFit after = FitOf(target, b, c);
      const Eigen::Vector3d on = (b.position - a.position).cross(c.position - a.position);
      if (std::abs(on.dot(move)) > most * on.norm() && FitOf(a, b, c).quality > kLeastQuality) {
        good = false;
        return;
      }
      if (!turns && after.quality >= kLeastQuality && after.facing >= FacetFit::kLeastFacing)
        return;
      const FacetFit before = FitOf(a, b, c);
      good = after.MayReplace(before, kLeastQuality) && (!turns || before.quality < kNoNormal);
    });
    return good;
  }

  // The other end gets edges that it may not have.
  bool JoinsCopies(HalfedgeHandle h) const {
    const VertexHandle to = state_.To(h);
    bool joins = false;
    state_.ForFacets(state_.From(h), [&](HalfedgeHandle side) {
      for (const VertexHandle v : {state_.To(side), state_.Opposite(side)}) {
        if (v == to || (state_[v].fixed < 0 && state_[to].fixed < 0)) continue;
        joins |= !state_.half_edges().find_halfedge(v, to).is_valid() && !state_.MayJoin(v, to);
      }
    });
    return joins;
  }

  // A corner beside the edge that would be left with two facets.
  bool LeavesFlap(HalfedgeHandle h) const {
    const OpenMesh::TriConnectivity& mesh = state_.half_edges();
    for (const HalfedgeHandle side : {h, Opposite(h)}) {
      if (mesh.is_boundary(side)) continue;
      const VertexHandle corner = state_.Opposite(side);
      if (mesh.valence(corner) <= (mesh.is_boundary(corner) ? 2U : 3U)) return true;
    }
    return false;
  }

  // By value: the target is one of the vertices that change.
  bool CollapseTo(HalfedgeHandle h, const RemeshVertex target) {
    const VertexHandle from = state_.From(h);
    const VertexHandle to = state_.To(h);
    if (!KeepsShape(from, to, target) || !KeepsShape(to, from, target) || LeavesFlap(h) ||
        JoinsCopies(h) || !state_.half_edges().is_collapse_ok(h)) {
      return false;
    }
    state_.half_edges().collapse(h);
    state_[to] = target;
    return true;
  }

  RemeshState& state_;
  const double longest_;  // of the wanted length, that an edge may become
};

}  // namespace

int CollapseShortEdges(RemeshState* state) {
  const OpenMesh::TriConnectivity& mesh = state->half_edges();
  Collapser collapser(state, kTooLong);
  int count = 0;
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    EdgeQueue queue;
    for (int e = 0; e < static_cast<int>(mesh.n_edges()); ++e) {
      const EdgeHandle edge(e);
      if (!state->IsAlive(edge)) continue;
      const double r = state->LengthRatio(edge);
      if (r < kTooShort) queue.emplace_back(r, edge);
    }
    SortQueue(&queue);
    int done = 0;
    for (const auto& [key, edge] : queue) {
      if (!state->IsAlive(edge) || state->LengthRatio(edge) >= kTooShort) continue;
      done += static_cast<int>(collapser.Collapse(edge));
    }
    count += done;
    if (done < kWorthAPass * static_cast<double>(queue.size())) break;
  }
  return count;
}

int CollapseSlivers(RemeshState* state, double least_quality) {
  const OpenMesh::TriConnectivity& mesh = state->half_edges();
  constexpr double kStillBearable = 1.6;
  Collapser collapser(state, kStillBearable);
  int count = 0;
  for (int f = 0; f < static_cast<int>(mesh.n_faces()); ++f) {
    const FaceHandle face(f);
    if (!state->IsAlive(face)) continue;
    HalfedgeHandle h = mesh.halfedge_handle(face);
    HalfedgeHandle shortest = h;
    for (int c = 0; c < 3; ++c, h = mesh.next_halfedge_handle(h)) {
      if (state->Length(h) < state->Length(shortest)) shortest = h;
    }
    VertexHandle v[3];
    state->Corners(face, v);
    if (FitOf((*state)[v[0]], (*state)[v[1]], (*state)[v[2]]).quality >= least_quality) continue;
    count += static_cast<int>(collapser.Collapse(mesh.edge_handle(shortest)));
  }
  return count;
}

}  // namespace burin
