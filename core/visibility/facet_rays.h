// Packets of rays against a mesh that answer with facets: which one a pixel sees, and whether one
// hides a point of another. What an obstacle is stands in core/visibility/visibility.h.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/mesh/embree_mesh.h"
#include "core/mesh/mesh.h"
#include "core/scene/camera.h"

namespace burin {

class FacetRays {
 public:
  // Copies the mesh.
  explicit FacetRays(const TriangleMesh& mesh);

  const TriangleMesh& mesh() const { return mesh_; }

  // visible[k] is 1 where facet facets[k] faces the camera and nothing that the camera sees lies between it
  // and points[k], else 0. `facing` is FacingFacets() of its centre.
  void CastToCamera(const Camera& camera, const std::vector<uint8_t>& facing,
                    const Eigen::Vector3d* points, const int* facets, int count,
                    uint8_t* visible) const;

 private:
  TriangleMesh mesh_;
  EmbreeMesh embree_;
};

}  // namespace burin
