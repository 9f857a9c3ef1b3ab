// Single rays against a triangle mesh, exact where they hit: what pictures, depth maps and synthetic
// scenes are made with.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>

#include "core/mesh/mesh.h"
#include "core/scene/camera.h"

namespace burin {

class EmbreeMesh;

struct RayHit {
  int face = -1;                                    // index into mesh.faces
  double distance = 0;                              // along the ray, in lengths of its direction
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  // on the plane of the face
  Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();  // weights of the three vertices
};

// Embree finds the face in single precision; distance and point are then those of the face's plane in
// double precision. Safe to use from several threads.
class MeshRays {
 public:
  // Keeps a reference: the mesh must outlive this and not change.
  explicit MeshRays(const TriangleMesh& mesh);
  // With an origin near the mesh for Embree's coordinates; above it is the middle of the bounding box.
  MeshRays(const TriangleMesh& mesh, const Eigen::Vector3d& origin);
  ~MeshRays();
  MeshRays(const MeshRays&) = delete;
  MeshRays& operator=(const MeshRays&) = delete;

  // The closest face of either orientation along origin + distance * direction, 0 < distance < `far`, to
  // single precision.
  bool Intersect(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, RayHit* hit,
                 double far = std::numeric_limits<double>::infinity()) const;

  // A surface point with outward normal `normal` is in the image, in front of the camera, faces it,
  // and nothing lies between them. Surface closer than 1e-4 of the viewing distance to the point
  // does not hide it (it is taken for the surface the point lies on).
  bool Sees(const Camera& camera, const Eigen::Vector3d& point,
            const Eigen::Vector3d& normal) const;

  const TriangleMesh& mesh() const { return mesh_; }

 private:
  const TriangleMesh& mesh_;
  std::unique_ptr<EmbreeMesh> embree_;
};

}  // namespace burin
