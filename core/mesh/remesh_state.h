// The surface while it is remeshed (core/mesh/remesh.h): half-edges, where each vertex is and what it knows of the
// input, and how well a facet lies.
#pragma once

#include <Eigen/Core>
#include <OpenMesh/Core/Mesh/TriConnectivity.hh>
#include <algorithm>
#include <vector>

#include "core/mesh/facet_quality.h"
#include "core/mesh/mesh.h"
#include "core/mesh/remesh.h"
#include "core/mesh/surface_walk.h"

namespace burin {

struct RemeshVertex {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // of the input there, smoothed
  double length = 0;                                 // wanted of its edges
  int facet = -1;                                    // of the input, with the nearest point
  int border = -1;  // at a border: the nearest stretch of the input's (RemeshState::border_next)
  int fixed = -1;   // the input vertex that it is and stays; -1: it may move
};

// What a facet that remeshing makes is judged by: its quality, and the cosine of its normal to the input's normals
// at its corners; -1 without area.
struct FacetFit {
  double quality = 0;
  double facing = -1;
  // Good enough, or no worse than what was there.
  bool MayReplace(const FacetFit& before, double least_quality) const {
    return facing >= std::min(kLeastFacing, before.facing) &&
           quality >= std::min(least_quality, before.quality);
  }
  static constexpr double kLeastFacing = 0.1;
};

class RemeshState {
 public:
  using VertexHandle = OpenMesh::VertexHandle;
  using HalfedgeHandle = OpenMesh::HalfedgeHandle;
  using EdgeHandle = OpenMesh::EdgeHandle;
  using FaceHandle = OpenMesh::FaceHandle;

  // Keeps references to the arguments.
  RemeshState(const TriangleMesh& input, const std::vector<double>& edge_length,
              const std::vector<char>* keep);

  Remeshed Take() const;
  // Forgets what is deleted. Handles change.
  void Compact();

  OpenMesh::TriConnectivity& half_edges() { return half_edges_; }
  const OpenMesh::TriConnectivity& half_edges() const { return half_edges_; }
  const SurfaceWalk& walk() const { return walk_; }

  RemeshVertex& operator[](VertexHandle v) { return vertices_[v.idx()]; }
  const RemeshVertex& operator[](VertexHandle v) const { return vertices_[v.idx()]; }
  std::vector<RemeshVertex>& vertices() { return vertices_; }
  const Eigen::Vector3d& Position(VertexHandle v) const { return vertices_[v.idx()].position; }
  VertexHandle Add(const RemeshVertex& vertex);

  // A vertex at `position`, its facet found from that of `near`, like which it is otherwise.
  RemeshVertex At(const Eigen::Vector3d& position, const RemeshVertex& near) const;
  // The same, put onto the surface; where near.border is set, onto the border.
  RemeshVertex OnSurfaceAt(const Eigen::Vector3d& position, const RemeshVertex& near) const;
  double DistanceToSurface(const Eigen::Vector3d& position, const RemeshVertex& near) const;
  // The `far` of SurfaceWalk::Find where edges of this length are wanted.
  static double Far(double length) { return 0.1 * length; }
  // Nearest point of the input's border; *stretch is where to start and where it is.
  Eigen::Vector3d OnBorder(const Eigen::Vector3d& position, int* stretch) const;
  Eigen::Vector3d BorderDirection(int stretch) const;  // unit; zero for a stretch without length

  VertexHandle From(HalfedgeHandle h) const { return half_edges_.from_vertex_handle(h); }
  VertexHandle To(HalfedgeHandle h) const { return half_edges_.to_vertex_handle(h); }
  VertexHandle Opposite(HalfedgeHandle h) const {
    return half_edges_.to_vertex_handle(half_edges_.next_halfedge_handle(h));
  }
  bool IsAlive(VertexHandle v) const { return !half_edges_.status(v).deleted(); }
  bool IsAlive(EdgeHandle e) const { return !half_edges_.status(e).deleted(); }
  bool IsAlive(FaceHandle f) const { return !half_edges_.status(f).deleted(); }
  // The input facet that a face is and stays; -1: it may change.
  int KeptAs(FaceHandle f) const {
    return f.idx() < static_cast<int>(kept_.size()) ? kept_[f.idx()] : -1;
  }
  // Must stay: beside a facet that is kept, or on a cut.
  bool IsFixed(EdgeHandle e) const;

  // Whether an edge between two vertices that have none would be one of two facets only: of a fixed vertex there may be
  // copies, at a cut, which are one vertex in the end.
  bool MayJoin(VertexHandle a, VertexHandle b) const;

  double Length(HalfedgeHandle h) const { return (Position(To(h)) - Position(From(h))).norm(); }
  double WantedLength(HalfedgeHandle h) const {
    return 0.5 * ((*this)[To(h)].length + (*this)[From(h)].length);
  }

  double LengthRatio(EdgeHandle e) const {
    const HalfedgeHandle h = half_edges_.halfedge_handle(e, 0);
    return Length(h) / WantedLength(h);
  }

  // The corners of a face, in order.
  void Corners(FaceHandle f, VertexHandle (&corners)[3]) const;

  // visit(halfedge) for those from v that have a facet to their left.
  template <typename Visit>
  void ForFacets(VertexHandle v, const Visit& visit) const {
    const HalfedgeHandle start = half_edges_.halfedge_handle(v);
    HalfedgeHandle h = start;
    do {
      if (!half_edges_.is_boundary(h)) visit(h);
      h = half_edges_.cw_rotated_halfedge_handle(h);
    } while (h != start);
  }

 private:
  bool HasNeighborFixedTo(VertexHandle v, int input_vertex) const;
  void AddFaces(const std::vector<char>* keep);
  void FindBorders();
  // Length and normal at a point of vertex->facet.
  void ReadInput(const TrianglePoint& at, RemeshVertex* vertex) const;

  const TriangleMesh& input_;
  const std::vector<double>& edge_length_;
  const SurfaceWalk walk_;
  std::vector<Eigen::Vector3d> normals_;  // by input vertex
  OpenMesh::TriConnectivity half_edges_;
  std::vector<RemeshVertex> vertices_;  // by half-edge vertex
  std::vector<int> kept_;               // by half-edge face; those beyond are new
  // The input's borders: stretch s leads from border_point_[s] to border_point_[border_next_[s]].
  std::vector<Eigen::Vector3d> border_point_;
  std::vector<int> border_next_;
  std::vector<int> border_last_;
};

// How a facet lies.
FacetFit FitOf(const RemeshVertex& a, const RemeshVertex& b, const RemeshVertex& c);

}  // namespace burin
