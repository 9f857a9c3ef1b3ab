// What the cameras see of a mesh, by rays: grey levels as the synthetic scenes photograph them, and
// depth maps. Rays of a pixel are spread evenly over its square.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <opencv2/core.hpp>
#include <vector>

#include "core/scene/camera.h"
#include "core/visibility/mesh_rays.h"

namespace burin {

// The image point that ray `sample` of the samples_per_axis^2 rays of a pixel goes through.
inline Eigen::Vector2d SamplePoint(int col, int row, int sample, int samples_per_axis) {
  return {col + (sample % samples_per_axis + 0.5) / samples_per_axis,
          row + (sample / samples_per_axis + 0.5) / samples_per_axis};
}

// Grey level of a surface point with unit normal; called from several threads.
using SurfaceShader =
    std::function<double(const Eigen::Vector3d& point, const Eigen::Vector3d& unit_normal)>;

// Mean of shader over the samples_per_axis^2 rays of each pixel; rays that miss count as `background`. Normals are interpolated from `vertex_normals` (VertexNormals).
// Returns camera.height x camera.width grey levels, not quantised.
cv::Mat1f RenderView(const MeshRays& rays, const std::vector<Eigen::Vector3d>& vertex_normals,
                     const Camera& camera, const SurfaceShader& shader, double background,
                     int samples_per_axis);

// Camera z of the first surface along the ray through each pixel's centre, world units; 0 where there
// is none.
cv::Mat1f RenderDepth(const MeshRays& rays, const Camera& camera);

}  // namespace burin
