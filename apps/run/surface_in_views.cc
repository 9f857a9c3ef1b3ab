#include "apps/run/surface_in_views.h"

#include <algorithm>
#include <cmath>

#include "core/mesh/projected_area.h"
#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kFaceGrain = 2048;
// Pieces that conforming bisection makes beyond those of the faces that are too large.
constexpr double kConforming = 1.0;

}  // namespace

SurfaceInViews LookAtSurface(const Scene& scene, const TriangleMesh& mesh) {
  const size_t view_count = scene.views.size();
  std::vector<Eigen::Matrix<double, 3, 4>> projections;
  std::vector<Eigen::Vector3d> centers;
  for (const View& view : scene.views) {
    projections.push_back(view.camera.ProjectionMatrix());
    centers.push_back(view.camera.Center());
  }
  const int faces = static_cast<int>(mesh.faces.size());
  const int slices = (faces + kFaceGrain - 1) / kFaceGrain;
  SurfaceInViews surface;
  surface.sharpest_area.assign(faces, 0);
  std::vector<std::vector<double>> covered(slices, std::vector<double>(view_count, 0));
  std::vector<double> area_by_views(slices, 0);
  ParallelFor(slices, 1, [&](int begin, int end) {
    for (int slice = begin; slice < end; ++slice) {
      for (int f = slice * kFaceGrain; f < std::min(faces, (slice + 1) * kFaceGrain); ++f) {
        const Eigen::Vector3d normal = FaceAreaNormal(mesh, f);
        const Eigen::Vector3d& a = mesh.vertices[mesh.faces[f][0]];
        int seen = 0;
        for (size_t v = 0; v < view_count; ++v) {
          if (normal.dot(centers[v] - a) <= 0) continue;
          const Camera& camera = scene.views[v].camera;
          const double area =
              ProjectedArea(projections[v], camera.width, camera.height, camera.near_depth, a,
                            mesh.vertices[mesh.faces[f][1]], mesh.vertices[mesh.faces[f][2]]);
          if (area <= 0) continue;
          ++seen;
          covered[slice][v] += area;
          surface.sharpest_area[f] = std::max(surface.sharpest_area[f], area);
        }
        area_by_views[slice] += seen * surface.sharpest_area[f];
      }
    }
  });
  surface.covered.assign(view_count, 0);
  double by_views = 0;
  double total = 0;
  for (int slice = 0; slice < slices; ++slice) {
    by_views += area_by_views[slice];
    for (size_t v = 0; v < view_count; ++v) surface.covered[v] += covered[slice][v];
  }
  for (const double area : surface.sharpest_area) total += area;
  surface.views_per_area = total > 0 ? by_views / total : 0;
  for (size_t v = 0; v < view_count; ++v) {
    const Camera& camera = scene.views[v].camera;
    surface.covered[v] =
        std::min(surface.covered[v], static_cast<double>(camera.width) * camera.height);
  }
  return surface;
}

int64_t ExpectedFaces(const SurfaceInViews& surface, double max_facet_px, int level) {
  const double max_area = std::ldexp(max_facet_px, 2 * level);  // at full resolution
  double faces = 0;
  double split = 0;
  for (const double area : surface.sharpest_area) {
    if (area <= max_area) {
      faces += 1;
    } else {
      split += std::exp2(std::ceil(std::log2(area / max_area)));
    }
  }
  return static_cast<int64_t>(faces + kConforming * split);
}

}  // namespace burin
