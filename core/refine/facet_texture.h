// Whether photographs show anything on a facet: what decides that it is worth splitting.
//
// Sky, and other background without texture, holds no window that says where a surface is. A surface that a
// start has there all the same would be cut into as many facets as the photographs have pixels of it.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/pyramid.h"
#include "core/visibility/mesh_rays.h"

namespace burin {

class FacetTexture {
 public:
  // Keeps references.
  FacetTexture(const std::vector<LevelView>& views, const TriangleMesh& mesh);

  // Some point of triangle abc, a piece of the mesh, has in two views that see it a 5x5 window whose standard deviation is at
  // least 1.5 times the view's noise and 2 % of the photographs' contrast. Points are a window apart in the
  // sharpest view.
  bool InTwoViews(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                  const Eigen::Vector3d& c) const;

 private:
  bool IsTextured(int view, const Eigen::Vector3d& point) const;

  const std::vector<LevelView>& views_;
  const MeshRays rays_;
  std::vector<Eigen::Vector3d> centers_;
  std::vector<double> least_variance_;  // by view
};

}  // namespace burin
