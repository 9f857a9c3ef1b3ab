// Which pieces of the faces of a mesh are too large in the views that see them.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/camera.h"

namespace burin {

// With the bounds, and the views that count for a face, of core/mesh/subdivide.h.
class SizeInViews {
 public:
  // Keeps references to `mesh`, whose vertices may be added to, and `cameras`.
  SizeInViews(const TriangleMesh& mesh, const std::vector<Camera>& cameras, double max_facet_px,
              double max_edge_px, const std::vector<std::vector<char>>* face_visible_in_view);

  // Of the piece of a face with these vertices.
  bool IsTooLarge(int face, const Eigen::Vector3i& corners) const;

 private:
  double AreaInView(int i, const Eigen::Vector3i& corners) const;
  double LargestFootprint(int i, const Eigen::Vector3i& corners) const;

  const TriangleMesh& mesh_;
  const std::vector<Camera>& cameras_;
  const double max_facet_px_;
  const double max_edge_px_;
  std::vector<Eigen::Matrix<double, 3, 4>> projections_;  // per camera
  std::vector<std::vector<int>> views_;  // that count for each face, where it is largest first
};

}  // namespace burin
