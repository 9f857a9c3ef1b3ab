#include "core/scene/track_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/support/median.h"

namespace burin {
namespace {

constexpr size_t kLeastMeasurements = 10;

}  // namespace

TrackErrors MeasureTrackErrors(const Scene& scene) {
  std::vector<std::vector<double>> of_view(scene.views.size());
  for (size_t p = 0; p < scene.points.size(); ++p) {
    const Eigen::Vector3d& position = scene.points[p].position;
    for (const Measurement& measured : scene.tracks.Of(p)) {
      const Camera& camera = scene.views[measured.view].camera;
      of_view[measured.view].push_back(
          camera.Depth(position) > 0 ? (camera.Project(position) - measured.image_point).norm()
                                     : std::numeric_limits<double>::infinity());
    }
  }
  TrackErrors errors;
  for (size_t v = 0; v < of_view.size(); ++v) {
    std::vector<double>& px = of_view[v];
    const bool enough = px.size() >= kLeastMeasurements;
    errors.median_px.push_back(enough ? Median(std::move(px))
                                      : std::numeric_limits<double>::quiet_NaN());
    if (!enough) continue;
    ++errors.known;
    const int side = std::max(scene.views[v].camera.width, scene.views[v].camera.height);
    if (errors.median_px[v] > std::min(kMostTrackErrorPx, kMostTrackErrorShare * side)) {
      errors.off.push_back(static_cast<int>(v));
    }
  }
  std::stable_sort(errors.off.begin(), errors.off.end(),
                   [&](int a, int b) { return errors.median_px[a] > errors.median_px[b]; });
  return errors;
}

}  // namespace burin
