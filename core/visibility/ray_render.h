// Rays against a triangle mesh, and an antialiased renderer on top: how the synthetic scenes get
// their images, depth maps and visibility.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/camera.h"

namespace burin {

struct RayHit {
  int face = -1;                                    // index into mesh.faces
  double distance = 0;                              // along the ray, in lengths of its direction
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  // on the plane of the face
  Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();  // weights of the three vertices
};

// A bounding-volume hierarchy over a mesh. Embree finds the face in single precision; distance and
// point are then those of the face's plane in double precision. Safe to use from several threads.
class MeshRays {
 public:
  // Keeps a reference: the mesh must outlive this and not change.
  explicit MeshRays(const TriangleMesh& mesh);
  ~MeshRays();
  MeshRays(const MeshRays&) = delete;
  MeshRays& operator=(const MeshRays&) = delete;

  // The closest face of either orientation along origin + distance * direction, distance > 0.
  bool Intersect(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                 RayHit* hit) const;

  // A surface point with outward normal `normal` is in the image, in front of the camera, faces it,
  // and nothing lies between them. Surface closer than 1e-4 of the viewing distance to the point
  // does not hide it (it is taken for the surface the point lies on).
  bool Sees(const Camera& camera, const Eigen::Vector3d& point,
            const Eigen::Vector3d& normal) const;

  const TriangleMesh& mesh() const { return mesh_; }

 private:
  const TriangleMesh& mesh_;
  struct Handles;
  std::unique_ptr<Handles> handles_;
};

// Grey level of a surface point with unit normal; called from several threads.
using SurfaceShader =
    std::function<double(const Eigen::Vector3d& point, const Eigen::Vector3d& unit_normal)>;

// Mean of shader over samples_per_axis^2 rays spread evenly over each pixel's square; rays that
// miss count as `background`. Normals are interpolated from `vertex_normals` (VertexNormals).
// Returns camera.height x camera.width grey levels, not quantised.
cv::Mat1f RenderView(const MeshRays& rays, const std::vector<Eigen::Vector3d>& vertex_normals,
                     const Camera& camera, const SurfaceShader& shader, double background,
                     int samples_per_axis);

// Camera z in world units of the surface seen at each pixel's centre; 0 where there is none.
cv::Mat1f RenderDepth(const MeshRays& rays, const Camera& camera);

}  // namespace burin
