#include "core/mesh/remesh_state.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/mesh/manifold_cut.h"
#include "core/mesh/openmesh_silence.h"
#include "core/mesh/smoothed_normals.h"
#include "core/support/parallel.h"

namespace burin {
namespace {

// Of the normals that facets are judged by: what noise crumples is ironed, not kept.
constexpr int kSmoothingRounds = 3;
constexpr int kVertexGrain = 1024;

}  // namespace

FacetFit FitOf(const RemeshVertex& a, const RemeshVertex& b, const RemeshVertex& c) {
  const Eigen::Vector3d u = b.position - a.position;
  const Eigen::Vector3d v = c.position - a.position;
  const Eigen::Vector3d area_normal = u.cross(v);
  const double area = area_normal.norm();
  const double squares = u.squaredNorm() + v.squaredNorm() + (u - v).squaredNorm();
  const Eigen::Vector3d normal = a.normal + b.normal + c.normal;
  const double length = normal.norm();
  FacetFit fit;
  if (!(area > 1e-12 * squares)) return fit;
  fit.quality = 2 * std::sqrt(3.0) * area / squares;
  fit.facing = length > 0 ? area_normal.dot(normal) / (area * length) : 0.0;
  return fit;
}

RemeshState::RemeshState(const TriangleMesh& input, const std::vector<double>& edge_length,
                         const std::vector<char>* keep)
    : input_(input), edge_length_(edge_length), walk_(input) {
  normals_ = SmoothedNormals(input, walk_.vertex_faces(),
                             VertexNeighbors(input, walk_.vertex_faces()), kSmoothingRounds);
  half_edges_.request_vertex_status();
  half_edges_.request_edge_status();
  half_edges_.request_halfedge_status();
  half_edges_.request_face_status();
  AddFaces(keep);
  FindBorders();
}

void RemeshState::AddFaces(const std::vector<char>* keep) {
  const std::vector<int> label = LabelCorners(input_);
  std::vector<int> vertex_of_label(label.size(), -1);
  std::vector<int> copies(input_.vertices.size(), 0);
  std::vector<int> input_vertex;
  const auto add = [&](int v) {
    ++copies[v];
    input_vertex.push_back(v);
    RemeshVertex vertex;
    vertex.position = input_.vertices[v];
    vertex.normal = normals_[v];
    vertex.length = edge_length_[v];
    vertex.facet = *walk_.vertex_faces().Begin(v);
    return Add(vertex).idx();
  };
  const OpenMeshSilence silence;  // what add_face refuses is dealt with below
  for (size_t f = 0; f < input_.faces.size(); ++f) {
    const Eigen::Vector3i& face = input_.faces[f];
    if (RepeatsVertex(face)) continue;
    VertexHandle corner[3];
    for (int c = 0; c < 3; ++c) {
      int& vertex = vertex_of_label[label[3 * f + c]];
      if (vertex < 0) vertex = add(face[c]);
      corner[c] = VertexHandle(vertex);
    }
    if (!half_edges_.add_face(corner, 3).is_valid()) {
      for (int c = 0; c < 3; ++c) corner[c] = VertexHandle(add(face[c]));
      half_edges_.add_face(corner, 3);
    }
    const bool stays = keep != nullptr && (*keep)[f] != 0;
    kept_.push_back(stays ? static_cast<int>(f) : -1);
    if (!stays) continue;
    for (const VertexHandle v : corner) vertices_[v.idx()].fixed = input_vertex[v.idx()];
  }
  for (size_t v = 0; v < vertices_.size(); ++v) {
    if (copies[input_vertex[v]] > 1) vertices_[v].fixed = input_vertex[v];
  }
}

void RemeshState::FindBorders() {
  std::vector<int> stretch(vertices_.size(), -1);
  const auto stretch_from = [&](VertexHandle v) {
    int& s = stretch[v.idx()];
    if (s < 0) {
      s = static_cast<int>(border_point_.size());
      border_point_.push_back(Position(v));
      border_next_.push_back(-1);
      border_last_.push_back(-1);
      vertices_[v.idx()].border = s;
    }
    return s;
  };
  for (int h = 0; h < static_cast<int>(half_edges_.n_halfedges()); ++h) {
    const HalfedgeHandle half_edge(h);
    if (!half_edges_.is_boundary(half_edge)) continue;
    const int from = stretch_from(From(half_edge));
    const int to = stretch_from(To(half_edge));
    border_next_[from] = to;
    border_last_[to] = from;
  }
}

void RemeshState::Compact() {
  OpenMesh::VPropHandleT<int> old_vertex;
  OpenMesh::FPropHandleT<int> old_face;
  half_edges_.add_property(old_vertex);
  half_edges_.add_property(old_face);
  for (const VertexHandle v : half_edges_.vertices()) {
    half_edges_.property(old_vertex, v) = v.idx();
  }
  for (const FaceHandle f : half_edges_.faces()) half_edges_.property(old_face, f) = f.idx();
  half_edges_.garbage_collection();
  std::vector<RemeshVertex> vertices(half_edges_.n_vertices());
  for (size_t v = 0; v < vertices.size(); ++v) {
    vertices[v] = vertices_[half_edges_.property(old_vertex, VertexHandle(static_cast<int>(v)))];
  }
  vertices_ = std::move(vertices);
  std::vector<int> kept(half_edges_.n_faces(), -1);
  for (size_t f = 0; f < kept.size(); ++f) {
    const size_t old = half_edges_.property(old_face, FaceHandle(static_cast<int>(f)));
    if (old < kept_.size()) kept[f] = kept_[old];
  }
  kept_ = std::move(kept);
  half_edges_.remove_property(old_vertex);
  half_edges_.remove_property(old_face);
}

RemeshState::VertexHandle RemeshState::Add(const RemeshVertex& vertex) {
  vertices_.push_back(vertex);
  return half_edges_.add_vertex();
}

RemeshVertex RemeshState::At(const Eigen::Vector3d& position, const RemeshVertex& near) const {
  RemeshVertex vertex = near;
  const TrianglePoint at = walk_.Find(position, Far(near.length), &vertex.facet);
  vertex.position = position;
  ReadInput(at, &vertex);
  if (vertex.border >= 0) OnBorder(position, &vertex.border);
  return vertex;
}

void RemeshState::ReadInput(const TrianglePoint& at, RemeshVertex* vertex) const {
  const Eigen::Vector3d weights = walk_.Weights(vertex->facet, at);
  const Eigen::Vector3i& face = input_.faces[vertex->facet];
  vertex->length = 0;
  vertex->normal.setZero();
  for (int c = 0; c < 3; ++c) {
    vertex->length += weights[c] * edge_length_[face[c]];
    vertex->normal += weights[c] * normals_[face[c]];
  }
  vertex->normal.normalize();
}

RemeshVertex RemeshState::OnSurfaceAt(const Eigen::Vector3d& position,
                                      const RemeshVertex& near) const {
  if (near.border >= 0) {
    int stretch = near.border;
    return At(OnBorder(position, &stretch), near);
  }
  RemeshVertex vertex = near;
  const TrianglePoint at = walk_.Find(position, Far(near.length), &vertex.facet);
  vertex.position = at.point;
  ReadInput(at, &vertex);
  return vertex;
}

double RemeshState::DistanceToSurface(const Eigen::Vector3d& position,
                                      const RemeshVertex& near) const {
  int facet = near.facet;
  return std::sqrt(walk_.Find(position, Far(near.length), &facet).squared_distance);
}

Eigen::Vector3d RemeshState::OnBorder(const Eigen::Vector3d& position, int* stretch) const {
  const auto nearest = [&](int s) {
    const Eigen::Vector3d& from = border_point_[s];
    const Eigen::Vector3d along = border_point_[border_next_[s]] - from;
    const double squared_length = along.squaredNorm();
    const double t = squared_length > 0 ? along.dot(position - from) / squared_length : 0.0;
    return Eigen::Vector3d(from + std::clamp(t, 0.0, 1.0) * along);
  };
  Eigen::Vector3d best = nearest(*stretch);
  for (bool moved = true; moved;) {
    moved = false;
    for (const int s : {border_next_[*stretch], border_last_[*stretch]}) {
      const Eigen::Vector3d point = nearest(s);
      if (!((point - position).squaredNorm() < (best - position).squaredNorm())) continue;
      best = point;
      *stretch = s;
      moved = true;
      break;
    }
  }
  return best;
}

Eigen::Vector3d RemeshState::BorderDirection(int stretch) const {
  return (border_point_[border_next_[stretch]] - border_point_[stretch]).normalized();
}

bool RemeshState::IsFixed(EdgeHandle e) const {
  const HalfedgeHandle h = half_edges_.halfedge_handle(e, 0);
  if ((*this)[To(h)].fixed < 0 || (*this)[From(h)].fixed < 0) return false;
  for (int side = 0; side < 2; ++side) {
    const HalfedgeHandle half = half_edges_.halfedge_handle(e, side);
    if (half_edges_.is_boundary(half) || KeptAs(half_edges_.face_handle(half)) >= 0) return true;
  }
  return false;
}

bool RemeshState::HasNeighborFixedTo(VertexHandle v, int input_vertex) const {
  for (const VertexHandle w : half_edges_.vv_range(v)) {
    if ((*this)[w].fixed == input_vertex) return true;
  }
  return false;
}

bool RemeshState::MayJoin(VertexHandle a, VertexHandle b) const {
  const int of_a = (*this)[a].fixed;
  const int of_b = (*this)[b].fixed;
  if (of_a >= 0 && of_b >= 0) return false;  // they may have an edge elsewhere
  if (of_a >= 0) return !HasNeighborFixedTo(b, of_a);
  return of_b < 0 || !HasNeighborFixedTo(a, of_b);
}

void RemeshState::Corners(FaceHandle f, VertexHandle (&corners)[3]) const {
  const HalfedgeHandle h = half_edges_.halfedge_handle(f);
  corners[0] = From(h);
  corners[1] = To(h);
  corners[2] = Opposite(h);
}

Remeshed RemeshState::Take() const {
  Remeshed result;
  std::vector<int> index(vertices_.size(), -1);
  std::vector<int> index_of_fixed(input_.vertices.size(), -1);
  const auto index_of = [&](VertexHandle v) {
    const RemeshVertex& vertex = (*this)[v];
    int& known = vertex.fixed >= 0 ? index_of_fixed[vertex.fixed] : index[v.idx()];
    if (known >= 0) return known;
    known = static_cast<int>(result.mesh.vertices.size());
    result.mesh.vertices.push_back(vertex.position);
    result.on.push_back({vertex.facet, Eigen::Vector3d::Zero()});
    return known;
  };
  for (int f = 0; f < static_cast<int>(half_edges_.n_faces()); ++f) {
    const FaceHandle face(f);
    if (!IsAlive(face)) continue;
    VertexHandle corners[3];
    Corners(face, corners);
    Eigen::Vector3i indices;
    for (int c = 0; c < 3; ++c) indices[c] = index_of(corners[c]);
    const int kept = KeptAs(face);
    result.kept.push_back(kept);
    if (kept >= 0) {  // in the order of the input
      for (int c = 0; c < 3; ++c) indices[c] = index_of_fixed[input_.faces[kept][c]];
    }
    result.mesh.faces.push_back(indices);
  }
  ParallelFor(static_cast<int>(result.on.size()), kVertexGrain, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      RemeshedVertex& on = result.on[v];
      const TrianglePoint at =
          walk_.Find(result.mesh.vertices[v], std::numeric_limits<double>::infinity(), &on.facet);
      on.weights = walk_.Weights(on.facet, at);
    }
  });
  return result;
}

}  // namespace burin
