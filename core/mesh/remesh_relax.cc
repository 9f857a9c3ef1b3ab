#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/mesh/remesh_steps.h"
#include "core/support/parallel.h"

namespace burin {
namespace {

using OpenMesh::FaceHandle;
using OpenMesh::HalfedgeHandle;
using OpenMesh::VertexHandle;

constexpr int kGrain = 1024;
// A direction in which planes (or lines) hold less than this, of the best held, is free.
constexpr double kHeld = 0.07;
// Of the wanted length: how far a vertex goes in one step, and the farthest that a sample of a facet may be off the
// input.
constexpr double kMaxStep = 0.5;
constexpr double kMaxOff = 0.7;
// Quality of a facet that a step may leave behind, unless it was worse.
constexpr double kLeastQuality = 0.05;
// Samples of a facet, by the weights of its corners.
constexpr double kSamples[][3] = {
    {4. / 6, 1. / 6, 1. / 6}, {1. / 6, 4. / 6, 1. / 6}, {1. / 6, 1. / 6, 4. / 6}};

// sum w (P (x - s))^2 about a point, for planes and lines with projectors P.
struct Quadric {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  Eigen::Vector3d vector = Eigen::Vector3d::Zero();
  double weight = 0;

  void Add(double w, const Eigen::Matrix3d& projector, const Eigen::Vector3d& offset) {
    matrix += w * projector;
    vector += w * (projector * offset);
    weight += w;
  }
  // The step that fits best; in directions that are hardly held `step` instead.
  Eigen::Vector3d Step(const Eigen::Vector3d& step) const {
    if (!(weight > 0)) return step;
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
    solver.computeDirect(matrix / weight);
    const Eigen::Matrix3d& axes = solver.eigenvectors();
    const Eigen::Vector3d held = axes.transpose() * vector / weight;
    const Eigen::Vector3d free = axes.transpose() * step;
    const double bound = std::pow(kHeld * solver.eigenvalues()[2], 4);
    Eigen::Vector3d result;
    for (int k = 0; k < 3; ++k) {
      const double value = std::max(0.0, solver.eigenvalues()[k]);
      const double hold = value * value * value;
      result[k] = (hold * held[k] + bound * free[k]) / (hold * value + bound);
    }
    return axes * result;
  }
};

class Relaxer {
 public:
  Relaxer(RemeshState* state, RelaxOn on) : state_(*state), mesh_(state->half_edges()), on_(on) {}

  void Run() {
    const int count = static_cast<int>(mesh_.n_vertices());
    if (on_ == RelaxOn::kPlanes) MeasurePlanes();
    before_ = state_.vertices();
    std::vector<RemeshVertex>& after = state_.vertices();
    moved_.assign(count, 0);
    std::vector<RemeshVertex> next(count);
    ParallelFor(count, kGrain, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        const VertexHandle v(i);
        if (!state_.IsAlive(v) || state_[v].fixed >= 0) continue;
        next[i] = Moved(v);
        moved_[i] = 1;
      }
    });
    ParallelFor(count, kGrain, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        if (moved_[i] != 0) after[i] = next[i];
      }
    });
    while (TakeBack()) {
    }
  }

 private:
  // The planes of the input under each facet, as each of its corners sees them.
  void MeasurePlanes() {
    planes_.resize(mesh_.n_halfedges());
    ParallelFor(static_cast<int>(mesh_.n_faces()), kGrain, [&](int begin, int end) {
      for (int f = begin; f < end; ++f) {
        if (state_.IsAlive(FaceHandle(f))) MeasurePlanesUnder(FaceHandle(f));
      }
    });
  }

  void MeasurePlanesUnder(FaceHandle face) {
    VertexHandle v[3];
    state_.Corners(face, v);
    const RemeshVertex* corners[3] = {&state_[v[0]], &state_[v[1]], &state_[v[2]]};
    const Eigen::Vector3d normal = (corners[1]->position - corners[0]->position)
                                       .cross(corners[2]->position - corners[0]->position);
    Quadric planes[3];
    for (const auto& weights : kSamples) {
      const int nearest = static_cast<int>(std::max_element(weights, weights + 3) - weights);
      Eigen::Vector3d sample = Eigen::Vector3d::Zero();
      for (int c = 0; c < 3; ++c) sample += weights[c] * corners[c]->position;
      int facet = corners[nearest]->facet;
      const TrianglePoint at =
          state_.walk().Find(sample, RemeshState::Far(corners[nearest]->length), &facet);
      const double bound = kMaxOff * corners[nearest]->length;
      const Eigen::Vector3d plane = FaceAreaNormal(state_.walk().mesh(), facet);
      const double area = plane.norm();
      if (at.squared_distance > bound * bound || !(area > 0) || plane.dot(normal) <= 0) continue;
      const Eigen::Matrix3d projector = plane * plane.transpose() / (area * area);
      for (int c = 0; c < 3; ++c) {
        planes[c].Add(weights[c] * normal.norm(), projector, at.point - corners[c]->position);
      }
    }
    HalfedgeHandle h = mesh_.halfedge_handle(face);
    for (int c = 0; c < 3; ++c, h = mesh_.next_halfedge_handle(h)) planes_[h.idx()] = planes[c];
  }

  RemeshVertex Moved(VertexHandle v) const {
    const RemeshVertex& vertex = state_[v];
    const Eigen::Vector3d step = vertex.border >= 0 ? StepAlongBorder(v) : StepAlongSurface(v);
    const double bound = kMaxStep * vertex.length;
    const double length = step.norm();
    const Eigen::Vector3d to = vertex.position + (length > bound ? bound / length : 1.0) * step;
    return on_ == RelaxOn::kSurface ? state_.OnSurfaceAt(to, vertex) : state_.At(to, vertex);
  }

  Eigen::Vector3d StepAlongSurface(VertexHandle v) const {
    const RemeshVertex& vertex = state_[v];
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    Quadric planes;
    double weight = 0;
    state_.ForFacets(v, [&](HalfedgeHandle side) {
      const RemeshVertex& b = state_[state_.To(side)];
      const RemeshVertex& c = state_[state_.Opposite(side)];
      const Eigen::Vector3d u = b.position - vertex.position;
      const Eigen::Vector3d w = c.position - vertex.position;
      const Eigen::Vector3d area_normal = u.cross(w);
      const double length = vertex.length + b.length + c.length;
      const double facet_weight = area_normal.norm() / (length * length);
      middle += facet_weight / 3 * (u + w);
      normal += area_normal;
      weight += facet_weight;
      if (on_ == RelaxOn::kSurface) {  // the facets' own planes hold the vertex where it is
        const double area = area_normal.norm();
        if (area > 0)
          planes.Add(area, area_normal * area_normal.transpose() / (area * area),
                     Eigen::Vector3d::Zero());
        return;
      }
      const Quadric& of_facet = planes_[side.idx()];
      planes.matrix += of_facet.matrix;
      planes.vector += of_facet.vector;
      planes.weight += of_facet.weight;
    });
    Eigen::Vector3d step = Eigen::Vector3d::Zero();
    if (weight > 0) step = middle / weight;
    const double squared_length = normal.squaredNorm();
    if (squared_length > 0) step -= normal * (normal.dot(step) / squared_length);
    return planes.Step(step);
  }

  Eigen::Vector3d StepAlongBorder(VertexHandle v) const {
    const RemeshVertex& vertex = state_[v];
    const HalfedgeHandle next = mesh_.halfedge_handle(v);  // at a border, along it
    const Eigen::Vector3d ends[2] = {
        state_.Position(state_.To(next)) - vertex.position,
        state_.Position(state_.From(mesh_.prev_halfedge_handle(next))) - vertex.position};
    const Eigen::Vector3d step = 0.5 * (ends[0] + ends[1]);
    Quadric lines;
    for (const Eigen::Vector3d& end : ends) {
      if (on_ == RelaxOn::kSurface) {  // as above
        const Eigen::Vector3d direction = end.normalized();
        lines.Add(end.norm(), Eigen::Matrix3d::Identity() - direction * direction.transpose(),
                  Eigen::Vector3d::Zero());
        continue;
      }
      for (const double t : {0.125, 0.375, 0.625, 0.875}) {
        const Eigen::Vector3d sample = vertex.position + t * end;
        int stretch = vertex.border;
        const Eigen::Vector3d at = state_.OnBorder(sample, &stretch);
        const Eigen::Vector3d direction = state_.BorderDirection(stretch);
        lines.Add((1 - t) * end.norm(),
                  Eigen::Matrix3d::Identity() - direction * direction.transpose(),
                  at - vertex.position);
      }
    }
    return lines.Step(step);
  }

  // Puts vertices of facets that became bad back to where they were. Each may be right alone and wrong together.
  bool TakeBack() {
    const int count = static_cast<int>(mesh_.n_faces());
    std::vector<char> bad(count, 0);
    ParallelFor(count, kGrain, [&](int begin, int end) {
      for (int f = begin; f < end; ++f) bad[f] = static_cast<char>(BecameBad(FaceHandle(f)));
    });
    bool any = false;
    for (int f = 0; f < count; ++f) {
      if (bad[f] == 0) continue;
      VertexHandle v[3];
      state_.Corners(FaceHandle(f), v);
      for (const VertexHandle corner : v) {
        if (moved_[corner.idx()] == 0) continue;
        moved_[corner.idx()] = 0;
        state_[corner] = before_[corner.idx()];
        any = true;
      }
    }
    return any;
  }

  bool BecameBad(FaceHandle face) const {
    if (!state_.IsAlive(face)) return false;
    VertexHandle v[3];
    state_.Corners(face, v);
    const RemeshVertex* now[3];
    const RemeshVertex* was[3];
    bool moved = false;
    for (int c = 0; c < 3; ++c) {
      now[c] = &state_[v[c]];
      was[c] = &before_[v[c].idx()];
      moved |= moved_[v[c].idx()] != 0;
    }
    if (!moved) return false;
    const FacetFit before = FitOf(*was[0], *was[1], *was[2]);
    // What faced away before is let go: relaxing irons it.
    if (before.facing < FacetFit::kLeastFacing) return false;
    return !FitOf(*now[0], *now[1], *now[2]).MayReplace(before, kLeastQuality);
  }

  RemeshState& state_;
  const OpenMesh::TriConnectivity& mesh_;
  const RelaxOn on_;
  std::vector<Quadric> planes_;  // of a facet for a corner, by the half-edge from there
  std::vector<RemeshVertex> before_;
  std::vector<char> moved_;  // by vertex
};

}  // namespace

void Relax(RemeshState* state, RelaxOn on) { Relaxer(state, on).Run(); }

}  // namespace burin
