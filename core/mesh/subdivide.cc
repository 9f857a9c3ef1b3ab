#include "core/mesh/subdivide.h"

#include <OpenMesh/Core/Mesh/TriConnectivity.hh>
#include <algorithm>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "core/mesh/manifold_cut.h"
#include "core/mesh/openmesh_silence.h"
#include "core/mesh/size_in_views.h"
#include "core/support/parallel.h"

namespace burin {
namespace {

using OpenMesh::EdgeHandle;
using OpenMesh::FaceHandle;
using OpenMesh::HalfedgeHandle;
using OpenMesh::VertexHandle;

class FaceSplitter {
 public:
  FaceSplitter(TriangleMesh* mesh, const std::vector<Camera>& cameras,
               const SubdivisionOptions& options,
               const std::vector<std::vector<char>>* face_visible_in_view)
      : mesh_(*mesh),
        max_face_count_(options.max_face_count),
        is_worth_it_(options.is_worth_it),
        size_in_views_(*mesh, cameras, options.max_facet_px, options.max_edge_px,
                       face_visible_in_view) {
    report_.input_face_count = static_cast<int>(mesh_.faces.size());
    BuildConnectivity();
  }

  SubdivisionReport Run() {
    const size_t input_vertex_count = mesh_.vertices.size();
    report_.reached_bound = true;
    std::vector<int> pending(connectivity_.n_faces());
    std::iota(pending.begin(), pending.end(), 0);
    for (int sweep = 1; !pending.empty(); ++sweep) {
      std::vector<char> too_large(pending.size(), 0);
      ParallelFor(static_cast<int>(pending.size()), 1024, [&](int begin, int end) {
        for (int i = begin; i < end; ++i) too_large[i] = IsTooLarge(FaceHandle(pending[i]));
      });
      changed_.clear();
      sweep_ = sweep;
      for (size_t i = 0; i < pending.size(); ++i) {
        // What was split on the way of another face is measured again in the next sweep.
        if (too_large[i] && changed_in_sweep_[pending[i]] != sweep) Split(pending[i]);
      }
      std::sort(changed_.begin(), changed_.end());
      pending = changed_;
    }
    report_.new_vertex_count = static_cast<int>(mesh_.vertices.size() - input_vertex_count);
    if (report_.new_vertex_count > 0) {
      TakeFaces();
    } else {
      report_.face_origin.resize(mesh_.faces.size());
      std::iota(report_.face_origin.begin(), report_.face_origin.end(), 0);
    }
    report_.face_count = static_cast<int>(mesh_.faces.size());
    return std::move(report_);
  }

 private:
  void BuildConnectivity() {
    const std::vector<int> label = LabelCorners(mesh_);
    std::vector<int> vertex_of_label(label.size(), -1);
    std::vector<char> used(mesh_.vertices.size(), 0);
    const OpenMeshSilence silence;  // what add_face refuses is dealt with below
    for (size_t f = 0; f < mesh_.faces.size(); ++f) {
      const Eigen::Vector3i& face = mesh_.faces[f];
      if (RepeatsVertex(face)) {
        kept_faces_.push_back(static_cast<int>(f));
        continue;
      }
      VertexHandle corner[3];
      for (int c = 0; c < 3; ++c) {
        int& vertex = vertex_of_label[label[3 * f + c]];
        if (vertex < 0) vertex = AddVertex(face[c], &used);
        corner[c] = VertexHandle(vertex);
      }
      if (!connectivity_.add_face(corner, 3).is_valid()) {
        for (int c = 0; c < 3; ++c) corner[c] = VertexHandle(AddVertex(face[c], &used));
        connectivity_.add_face(corner, 3);
      }
      origin_.push_back(static_cast<int>(f));
    }
    report_.kept_face_count = static_cast<int>(kept_faces_.size());
    changed_in_sweep_.assign(origin_.size(), 0);
    MeasureNewEdges();
    RegisterTwins();
  }

  int AddVertex(int mesh_vertex, std::vector<char>* used) {
    report_.copied_vertex_count += (*used)[mesh_vertex];
    (*used)[mesh_vertex] = 1;
    mesh_vertex_.push_back(mesh_vertex);
    return connectivity_.add_vertex().idx();
  }

  std::pair<int, int> Ends(EdgeHandle edge) const {
    const HalfedgeHandle half = connectivity_.halfedge_handle(edge, 0);
    const int a = mesh_vertex_[connectivity_.to_vertex_handle(half).idx()];
    const int b = mesh_vertex_[connectivity_.from_vertex_handle(half).idx()];
    return {std::min(a, b), std::max(a, b)};
  }

  // Third vertex of the face on a side of the edge; -1 - side where there is none.
  int Opposite(EdgeHandle edge, int side) const {
    const HalfedgeHandle half = connectivity_.halfedge_handle(edge, side);
    if (connectivity_.is_boundary(half)) return -1 - side;
    return mesh_vertex_[connectivity_.to_vertex_handle(connectivity_.next_halfedge_handle(half))
                            .idx()];
  }

  static std::uint64_t Key(const std::pair<int, int>& ends) {
    return (static_cast<std::uint64_t>(ends.first) << 32) | static_cast<std::uint32_t>(ends.second);
  }

  double SquaredLength(EdgeHandle edge) const {
    const auto [a, b] = Ends(edge);
    return (mesh_.vertices[a] - mesh_.vertices[b]).squaredNorm();
  }

  void MeasureNewEdges() {
    for (size_t e = squared_length_.size(); e < connectivity_.n_edges(); ++e) {
      squared_length_.push_back(SquaredLength(EdgeHandle(static_cast<int>(e))));
    }
  }

  // Half-edge edges that are one edge of the mesh, cut open.
  void RegisterTwins() {
    std::vector<std::pair<std::uint64_t, int>> keys;
    keys.reserve(connectivity_.n_edges());
    for (size_t e = 0; e < connectivity_.n_edges(); ++e) {
      keys.emplace_back(Key(Ends(EdgeHandle(static_cast<int>(e)))), static_cast<int>(e));
    }
    std::sort(keys.begin(), keys.end());
    for (size_t k = 0; k < keys.size(); ++k) {
      const bool same_as_last = k > 0 && keys[k].first == keys[k - 1].first;
      const bool same_as_next = k + 1 < keys.size() && keys[k].first == keys[k + 1].first;
      if (same_as_last || same_as_next) {
        twins_[keys[k].first].push_back(EdgeHandle(keys[k].second));
      }
    }
  }

  // All half-edge edges on the mesh edge of `edge`.
  std::vector<EdgeHandle> EdgesAt(EdgeHandle edge) const {
    if (!twins_.empty()) {
      const auto found = twins_.find(Key(Ends(edge)));
      if (found != twins_.end()) return found->second;
    }
    return {edge};
  }

  // A strict order of the edges of the mesh: by length, then by vertex index.
  bool IsLonger(EdgeHandle a, EdgeHandle b) const {
    const double length_a = squared_length_[a.idx()];
    const double length_b = squared_length_[b.idx()];
    if (length_a != length_b) return length_a > length_b;
    return a != b && Ends(a) > Ends(b);
  }

  EdgeHandle LongestEdge(FaceHandle face) const {
    const HalfedgeHandle first = connectivity_.halfedge_handle(face);
    const HalfedgeHandle second = connectivity_.next_halfedge_handle(first);
    EdgeHandle longest = connectivity_.edge_handle(first);
    for (HalfedgeHandle half : {second, connectivity_.next_halfedge_handle(second)}) {
      const EdgeHandle edge = connectivity_.edge_handle(half);
      if (IsLonger(edge, longest)) longest = edge;
    }
    return longest;
  }

  // A face at `edge` that has a longer one; invalid when there is none.
  FaceHandle BlockingFace(EdgeHandle edge) const {
    for (EdgeHandle twin : EdgesAt(edge)) {
      for (int side = 0; side < 2; ++side) {
        const FaceHandle face =
            connectivity_.face_handle(connectivity_.halfedge_handle(twin, side));
        if (face.is_valid() && IsLonger(LongestEdge(face), edge)) return face;
      }
    }
    return FaceHandle();
  }

  bool IsTooLarge(FaceHandle face) const {
    const Eigen::Vector3i corners = Corners(face);
    return size_in_views_.IsTooLarge(origin_[face.idx()], corners) &&
           (!is_worth_it_ || is_worth_it_(mesh_.vertices[corners[0]], mesh_.vertices[corners[1]],
                                          mesh_.vertices[corners[2]]));
  }

  Eigen::Vector3i Corners(FaceHandle face) const {
    HalfedgeHandle half = connectivity_.halfedge_handle(face);
    Eigen::Vector3i corners;
    for (int c = 0; c < 3; ++c) {
      corners[c] = mesh_vertex_[connectivity_.to_vertex_handle(half).idx()];
      half = connectivity_.next_halfedge_handle(half);
    }
    return corners;
  }

  // Splits the face once, and before it what blocks it. Each face on the way has a longer longest
  // edge than the one before, so the way ends and never touches a face further up on it.
  void Split(int face) {
    path_.assign(1, FaceHandle(face));
    while (!path_.empty()) {
      if (static_cast<std::int64_t>(connectivity_.n_faces()) >= max_face_count_) {
        report_.reached_bound = false;
        return;
      }
      const EdgeHandle edge = LongestEdge(path_.back());
      const FaceHandle blocking = BlockingFace(edge);
      if (blocking.is_valid()) {
        path_.push_back(blocking);
      } else if (SplitEdge(edge)) {
        path_.pop_back();
      } else {
        report_.reached_bound = false;
        return;
      }
    }
  }

  // False when the edge is so short that its midpoint is one of its ends.
  bool SplitEdge(EdgeHandle edge) {
    const auto [a, b] = Ends(edge);
    const Eigen::Vector3d midpoint = 0.5 * (mesh_.vertices[a] + mesh_.vertices[b]);
    if (midpoint == mesh_.vertices[a] || midpoint == mesh_.vertices[b]) return false;
    const int new_vertex = static_cast<int>(mesh_.vertices.size());
    mesh_.vertices.push_back(midpoint);
    report_.new_vertex_parents.push_back({a, b});
    const std::vector<EdgeHandle> twins = EdgesAt(edge);
    // The new edges are twins too, and those on the two sides of a fold onto itself become twins.
    const bool makes_twins = (!twins_.empty() && twins_.erase(Key({a, b})) > 0) ||
                             Opposite(edge, 0) == Opposite(edge, 1);
    for (EdgeHandle twin : twins) {
      const auto first_new_edge = static_cast<int>(connectivity_.n_edges());
      const FaceHandle side[2] = {
          connectivity_.face_handle(connectivity_.halfedge_handle(twin, 0)),
          connectivity_.face_handle(connectivity_.halfedge_handle(twin, 1))};
      const VertexHandle vertex = connectivity_.add_vertex();
      mesh_vertex_.push_back(new_vertex);
      connectivity_.split(twin, vertex);
      // split() makes one new face a side, in this order, and keeps the old handles for the others.
      for (FaceHandle old : side) {
        if (!old.is_valid()) continue;
        MarkChanged(old.idx());
        changed_in_sweep_.push_back(0);
        MarkChanged(static_cast<int>(origin_.size()));
        origin_.push_back(origin_[old.idx()]);
      }
      squared_length_[twin.idx()] = SquaredLength(twin);
      MeasureNewEdges();
      if (!makes_twins) continue;
      twins_[Key(Ends(twin))].push_back(twin);
      for (int e = first_new_edge; e < static_cast<int>(connectivity_.n_edges()); ++e) {
        twins_[Key(Ends(EdgeHandle(e)))].push_back(EdgeHandle(e));
      }
    }
    return true;
  }

  void MarkChanged(int face) {
    if (changed_in_sweep_[face] == sweep_) return;
    changed_in_sweep_[face] = sweep_;
    changed_.push_back(face);
  }

  // Faces by input face, so that what lies together stays together in memory.
  void TakeFaces() {
    std::vector<std::pair<int, int>> order;  // input face, half-edge face (-1: as it was)
    order.reserve(origin_.size() + kept_faces_.size());
    for (size_t f = 0; f < origin_.size(); ++f) order.emplace_back(origin_[f], static_cast<int>(f));
    for (int f : kept_faces_) order.emplace_back(f, -1);
    std::sort(order.begin(), order.end());
    std::vector<Eigen::Vector3i> faces;
    faces.reserve(order.size());
    for (const auto& [input_face, face] : order) {
      faces.push_back(face < 0 ? mesh_.faces[input_face] : Corners(FaceHandle(face)));
      report_.face_origin.push_back(input_face);
    }
    mesh_.faces = std::move(faces);
  }

  TriangleMesh& mesh_;  // vertices grow while splitting, faces are replaced at the end
  const std::int64_t max_face_count_;
  const decltype(SubdivisionOptions::is_worth_it) is_worth_it_;
  const SizeInViews size_in_views_;
  SubdivisionReport report_;

  OpenMesh::TriConnectivity connectivity_;
  std::vector<int> mesh_vertex_;        // per half-edge vertex: its index in mesh_.vertices
  std::vector<int> origin_;             // per half-edge face: the input face it is part of
  std::vector<double> squared_length_;  // per half-edge edge
  std::vector<int> kept_faces_;         // input faces that repeat a vertex
  // Mesh edges that are, or come from, several half-edge edges. Empty for most meshes.
  std::unordered_map<std::uint64_t, std::vector<EdgeHandle>> twins_;

  int sweep_ = 0;
  std::vector<int> changed_in_sweep_;  // per half-edge face
  std::vector<int> changed_;           // faces changed in this sweep
  std::vector<FaceHandle> path_;
};

}  // namespace

SubdivisionReport SplitLargeFaces(TriangleMesh* mesh, const std::vector<Camera>& cameras,
                                  const SubdivisionOptions& options,
                                  const std::vector<std::vector<char>>* face_visible_in_view) {
  return FaceSplitter(mesh, cameras, options, face_visible_in_view).Run();
}

}  // namespace burin
