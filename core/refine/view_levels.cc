#include "core/refine/view_levels.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/support/median.h"

namespace burin {
namespace {

constexpr size_t kVertices = 20000;  // looked at, at most about twice as many

// By view: how many times as wide its pixels are on the surface as the narrowest there. The median over the
// vertices in its image; 1 where there is none.
std::vector<double> RelativeFootprints(const Scene& scene, const TriangleMesh& mesh) {
  std::vector<std::vector<double>> ratios(scene.views.size());
  const size_t step = std::max<size_t>(1, mesh.vertices.size() / kVertices);
  std::vector<std::pair<size_t, double>> seen;  // view and footprint
  for (size_t v = 0; v < mesh.vertices.size(); v += step) {
    const Eigen::Vector3d& vertex = mesh.vertices[v];
    seen.clear();
    double narrowest = 0;
    for (size_t i = 0; i < scene.views.size(); ++i) {
      const Camera& camera = scene.views[i].camera;
      if (camera.Depth(vertex) <= 0 || !camera.Contains(camera.Project(vertex))) continue;
      seen.emplace_back(i, camera.Footprint(vertex));
      narrowest = seen.size() == 1 ? seen[0].second : std::min(narrowest, seen.back().second);
    }
    for (const auto& [view, footprint] : seen) ratios[view].push_back(footprint / narrowest);
  }
  std::vector<double> relative(ratios.size(), 1);
  for (size_t i = 0; i < ratios.size(); ++i) {
    if (!ratios[i].empty()) relative[i] = Median(ratios[i]);
  }
  return relative;
}

}  // namespace

ViewLevels::ViewLevels(const Scene& scene, const TriangleMesh& mesh, const LevelOptions& options)
    : options_(options) {
  const std::vector<double> relative = RelativeFootprints(scene, mesh);
  for (size_t i = 0; i < scene.views.size(); ++i) {
    side_.push_back(std::min(scene.views[i].camera.width, scene.views[i].camera.height));
    less_.push_back(std::max(0, static_cast<int>(std::lround(std::log2(relative[i]))) - 1));
  }
}

std::vector<ViewAtLevel> ViewLevels::At(int level) const {
  std::vector<ViewAtLevel> views(side_.size());
  for (size_t i = 0; i < views.size(); ++i) {
    ViewAtLevel& view = views[i];
    view.halvings = std::max(0, level - less_[i]);
    view.coarse = less_[i] > 0;
    view.takes_part =
        level == options_.finest || std::ldexp(side_[i], -view.halvings) >= options_.min_side_px;
  }
  return views;
}

int ViewLevels::Coarsest(const std::vector<CameraPair>& pairs,
                         const std::vector<CameraPair>& held_back) const {
  const auto enough = [&](int level) {
    const std::vector<ViewAtLevel> views = At(level);
    const auto taking_part = [&](const std::vector<CameraPair>& of) {
      return std::count_if(of.begin(), of.end(), [&](const CameraPair& pair) {
        return views[pair.reference].takes_part && views[pair.second].takes_part;
      });
    };
    return 2 * taking_part(pairs) >= static_cast<long>(pairs.size()) &&
           (held_back.empty() || taking_part(held_back) > 0);
  };
  int level = options_.finest + options_.count - 1;
  while (level > options_.finest && !enough(level)) --level;
  return level;
}

}  // namespace burin
