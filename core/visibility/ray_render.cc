#include "core/visibility/ray_render.h"

#include <Eigen/Geometry>

#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kRowsPerItem = 4;

}  // namespace

cv::Mat1f RenderView(const MeshRays& rays, const std::vector<Eigen::Vector3d>& vertex_normals,
                     const Camera& camera, const SurfaceShader& shader, double background,
                     int samples_per_axis) {
  cv::Mat1f image(camera.height, camera.width);
  const Eigen::Vector3d center = camera.Center();
  ParallelFor(camera.height, kRowsPerItem, [&](int begin, int end) {
    RayHit hit;
    for (int row = begin; row < end; ++row) {
      for (int col = 0; col < camera.width; ++col) {
        double sum = 0;
        for (int sample = 0; sample < samples_per_axis * samples_per_axis; ++sample) {
          const Eigen::Vector2d at = SamplePoint(col, row, sample, samples_per_axis);
          if (!rays.Intersect(center, camera.Ray(at.x(), at.y()), &hit)) {
            sum += background;
            continue;
          }
          const Eigen::Vector3i& face = rays.mesh().faces[hit.face];
          const Eigen::Vector3d normal = hit.barycentric[0] * vertex_normals[face[0]] +
                                         hit.barycentric[1] * vertex_normals[face[1]] +
                                         hit.barycentric[2] * vertex_normals[face[2]];
          sum += shader(hit.point, normal.normalized());
        }
        image(row, col) = static_cast<float>(sum / (samples_per_axis * samples_per_axis));
      }
    }
  });
  return image;
}

cv::Mat1f RenderDepth(const MeshRays& rays, const Camera& camera) {
  cv::Mat1f depth(camera.height, camera.width);
  const Eigen::Vector3d center = camera.Center();
  ParallelFor(camera.height, kRowsPerItem, [&](int begin, int end) {
    RayHit hit;
    for (int row = begin; row < end; ++row) {
      for (int col = 0; col < camera.width; ++col) {
        // Rays have unit depth, so the distance along them is the depth.
        const bool seen = rays.Intersect(center, camera.Ray(col + 0.5, row + 0.5), &hit);
        depth(row, col) = seen ? static_cast<float>(hit.distance) : 0.0F;
      }
    }
  });
  return depth;
}

}  // namespace burin
