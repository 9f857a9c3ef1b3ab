// The nearest point of a mesh, found by walking over it from where one was before.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/mesh/triangle_point.h"

namespace burin {

// Goes from facet to facet as long as that leads nearer. So it answers in a few steps, and never with a point of
// another sheet that happens to be near: what MeshDistance cannot promise. On a folded surface it may stop
// at a point that is only nearest among those around it. Any number of threads may ask.
class SurfaceWalk {
 public:
  // Keeps a reference to `mesh`, which may have faults of any kind.
  explicit SurfaceWalk(const TriangleMesh& mesh);

  const TriangleMesh& mesh() const { return mesh_; }
  const Adjacency& vertex_faces() const { return vertex_faces_; }

  // Starts at *facet, which becomes the facet of the answer. An answer that is farther than `far`, or than a quarter of
  // the facet's size, is doubted (beside a sharp edge one side may be far and the other near): then all
  // facets around are looked at, too.
  TrianglePoint Find(const Eigen::Vector3d& query, double far, int* facet) const;

  // The point as weights of the facet's corners: not negative, with sum 1.
  Eigen::Vector3d Weights(int facet, const TrianglePoint& at) const;

 private:
  TrianglePoint Closest(const Eigen::Vector3d& query, int facet) const;

  const TriangleMesh& mesh_;
  const Adjacency vertex_faces_;
  std::vector<std::array<int, 3>> across_;  // by facet: another at edge c, c+1; -1: none
};

}  // namespace burin
