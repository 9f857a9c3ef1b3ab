// The world that a refinement works in: X' = (X - origin) / footprint. One unit is about one pixel of full
// resolution, so that no tolerance, step or weight has a scale.
#pragma once

#include <Eigen/Core>

#include "core/mesh/mesh.h"
#include "core/scene/scene.h"

namespace burin {

struct NormalizedWorld {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // of the caller's world
  double footprint = 1;                              // world units of 1

  // Origin: the middle of the mesh's bounding box. Footprint: MedianFootprint, 0 when no view sees a vertex.
  static NormalizedWorld Of(const Scene& scene, const TriangleMesh& mesh);
  // A mesh of the caller's world, and back.
  TriangleMesh FromWorld(TriangleMesh mesh) const;
  TriangleMesh ToWorld(TriangleMesh mesh) const;
  // A camera of the caller's world, for an image resampled to that size.
  Camera FromWorld(const Camera& camera, int width, int height) const;
};

// Median over vertices of the smallest pixel footprint, full resolution, among the views that they
// project into; 0 when none does.
double MedianFootprint(const Scene& scene, const TriangleMesh& mesh);

}  // namespace burin
