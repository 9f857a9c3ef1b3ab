#include "core/scene/near_depth.h"

#include <algorithm>
#include <vector>

#include "core/scene/track_errors.h"

namespace burin {
namespace {

constexpr size_t kEnoughPoints = 50;
constexpr double kQuantile = 0.01;
constexpr double kNear = 0.05;

}  // namespace

void SetNearDepths(Scene* scene) {
  std::vector<std::vector<double>> depths(scene->views.size());
  for (const ScenePoint& point : scene->points) {
    for (const int i : point.views) {
      const double depth = scene->views[i].camera.Depth(point.position);
      if (depth > 0) depths[i].push_back(depth);
    }
  }
  for (const int i : MeasureTrackErrors(*scene).off) depths[i].clear();
  for (size_t i = 0; i < depths.size(); ++i) {
    if (depths[i].size() < kEnoughPoints) continue;
    const auto nearest =
        depths[i].begin() + static_cast<long>(kQuantile * static_cast<double>(depths[i].size()));
    std::nth_element(depths[i].begin(), nearest, depths[i].end());
    scene->views[i].camera.near_depth = kNear * *nearest;
  }
}

}  // namespace burin
