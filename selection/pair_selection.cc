#include "selection/pair_selection.h"

#include <algorithm>
#include <sstream>

#include "core/error.h"
#include "selection/mesh_parallax_pairs.h"
#include "selection/sparse_point_pairs.h"

namespace burin {
namespace {

constexpr size_t kCamerasNamedInError = 5;

// Why view i has no partner.
std::string Reason(const Scene& scene, const TriangleMesh& mesh, const PairSelection& selection,
                   int i) {
  std::ostringstream range;
  range << selection.min_parallax_deg << "-" << selection.max_parallax_deg << " deg";
  const auto n = static_cast<int>(scene.views.size());
  const auto row_max = [n, i](const auto& scores) {
    return *std::max_element(scores.begin() + static_cast<long>(i) * n,
                             scores.begin() + static_cast<long>(i + 1) * n);
  };
  if (selection.method != "mesh_parallax") {
    const auto sees =
        std::count_if(scene.points.begin(), scene.points.end(), [i](const ScenePoint& point) {
          return std::binary_search(point.views.begin(), point.views.end(), i);
        });
    if (sees == 0) return "sees no sparse point";
    if (row_max(CommonPointCounts(scene, 0, 180)) == 0) {
      return "shares no sparse point with another view";
    }
    return "shares sparse points with other views, but none under a parallax of " + range.str();
  }
  const bool inside =
      std::any_of(mesh.vertices.begin(), mesh.vertices.end(), [&](const Eigen::Vector3d& vertex) {
        const Camera& camera = scene.views[i].camera;
        return camera.Depth(vertex) > 0 && camera.Contains(camera.Project(vertex));
      });
  if (!inside) return "no vertex of the mesh projects into it";
  if (row_max(SharedFacetAreas(scene, mesh, 0, 180)) == 0) {
    return "no facet visible in it is visible in another view (facets seen from behind do not "
           "count)";
  }
  return "shares visible facets with other views, but none under a parallax of " + range.str();
}

}  // namespace

void PairsOptions::Describe(OptionSet* set) {
  set->Add("pairs.method", &method,
           "vu, sparse_points: common sparse points; mesh_parallax: shared visible surface; auto: "
           "sparse_points if there are points, else mesh_parallax",
           {"auto", "vu", "sparse_points", "mesh_parallax"});
  set->Add("pairs.per_camera", &per_camera, "Partners of each camera at most", 1, 1000);
  set->Add("pairs.min_parallax_deg", &min_parallax_deg,
           "Smallest parallax that counts, degrees; -1 = the method's own (vu 20, others 8)", -1,
           180);
  set->Add("pairs.max_parallax_deg", &max_parallax_deg,
           "Largest parallax that counts, degrees; -1 = the method's own (vu 60, others 45)", -1,
           180);
}

PairSelection SelectPairs(const Scene& scene, const TriangleMesh& mesh,
                          const PairsOptions& options) {
  PairSelection selection;
  selection.method = options.method;
  if (selection.method == "auto") {
    selection.method = scene.points.empty() ? "mesh_parallax" : "sparse_points";
  }
  const bool vu = selection.method == "vu";
  selection.min_parallax_deg =
      options.min_parallax_deg >= 0 ? options.min_parallax_deg : (vu ? 20 : 8);
  selection.max_parallax_deg =
      options.max_parallax_deg >= 0 ? options.max_parallax_deg : (vu ? 60 : 45);
  if (selection.min_parallax_deg >= selection.max_parallax_deg) {
    throw InputError("pairs.min_parallax_deg: must be below pairs.max_parallax_deg");
  }
  if (selection.method == "mesh_parallax") {
    selection.pairs = MeshParallaxPairs(scene, mesh, options.per_camera, selection.min_parallax_deg,
                                        selection.max_parallax_deg);
  } else {
    if (scene.points.empty()) {
      throw InputError("pairs.method = " + selection.method +
                       ": the scene has no sparse points; take mesh_parallax");
    }
    selection.pairs = SparsePointPairs(scene, options.per_camera, selection.min_parallax_deg,
                                       selection.max_parallax_deg);
  }
  const auto n = static_cast<int>(scene.views.size());
  std::string error = "no camera pair: ";
  size_t named = 0;
  for (int i = 0; i < n; ++i) {
    const bool has_partner =
        std::any_of(selection.pairs.begin(), selection.pairs.end(),
                    [i](const CameraPair& pair) { return pair.reference == i; });
    if (has_partner) continue;
    if (selection.warnings.size() < kCamerasNamedInError || !selection.pairs.empty()) {
      const std::string line = scene.views[i].name + " " + Reason(scene, mesh, selection, i);
      error += (named++ == 0 ? "" : "; ") + line;
      selection.warnings.push_back(line);
    }
  }
  if (selection.pairs.empty()) {
    if (static_cast<size_t>(n) > named) {
      error += "; and " + std::to_string(static_cast<size_t>(n) - named) + " more";
    }
    throw InputError(error);
  }
  return selection;
}

}  // namespace burin
