#include "apps/run/turned_axes.h"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <vector>

#include "core/evidence/verdict.h"
#include "core/support/error.h"
#include "selection/pair_selection.h"

namespace burin {
namespace {

constexpr size_t kViews = 8;
constexpr size_t kVerticesTried = 500;
constexpr int kLeastWindows = 100;  // more is asked for than of a mesh as it is: 46 are tried
constexpr double kLeastOnLine = 0.5;
constexpr double kLeastAtPlace = 0.7;
constexpr double kLeastSeen = 0.05;  // share of them in the image, of the view that sees most

// All but the identity.
std::vector<Eigen::Matrix3d> AxisRotations() {
  std::vector<Eigen::Matrix3d> rotations;
  std::array<int, 3> axes = {0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Eigen::Matrix3d rotation = Eigen::Matrix3d::Zero();
      for (int row = 0; row < 3; ++row) rotation(row, axes[row]) = (signs >> row & 1) != 0 ? -1 : 1;
      if (rotation.determinant() > 0 && !rotation.isIdentity()) rotations.push_back(rotation);
    }
  } while (std::next_permutation(axes.begin(), axes.end()));
  return rotations;
}

// As coordinates of the scene: "x, -z, y".
std::string AxesText(const Eigen::Matrix3d& rotation) {
  std::string text;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      if (rotation(row, column) == 0) continue;
      if (row > 0) text += ", ";
      if (rotation(row, column) < 0) text += "-";
      text += "xyz"[column];
    }
  }
  return text;
}

bool MayBeSeen(const Scene& scene, const TriangleMesh& mesh) {
  const size_t step = std::max<size_t>(1, mesh.vertices.size() / kVerticesTried);
  double most = 0;
  for (const View& view : scene.views) {
    double inside = 0;
    double tried = 0;
    for (size_t v = 0; v < mesh.vertices.size(); v += step) {
      const Eigen::Vector3d& vertex = mesh.vertices[v];
      if (view.camera.Depth(vertex) > 0 && view.camera.Contains(view.camera.Project(vertex))) {
        ++inside;
      }
      ++tried;
    }
    most = std::max(most, inside / tried);
  }
  return most >= kLeastSeen;
}

// Windows that agree where the mesh puts them, beyond chance; 0 for a mesh that does not fit.
double FitOf(const Scene& scene, const TriangleMesh& mesh, const PairsOptions& options) {
  if (!MayBeSeen(scene, mesh)) return 0;
  try {
    const SceneVerdict verdict = JudgeScene(scene, mesh, SelectPairs(scene, mesh, options).pairs);
    const Evidence& evidence = verdict.evidence;
    const bool fits = evidence.windows >= kLeastWindows && evidence.on_line >= kLeastOnLine &&
                      evidence.at_place >= kLeastAtPlace;
    return fits ? evidence.windows * evidence.on_line * (evidence.at_place - 0.5) : 0;
  } catch (const InputError&) {  // no view sees it, or no two see the same
    return 0;
  }
}

}  // namespace

std::string TurnedAxes(const Scene& scene, const TriangleMesh& mesh, const PairsOptions& options) {
  Scene some;
  some.views.assign(scene.views.begin(),
                    scene.views.begin() + static_cast<long>(std::min(kViews, scene.views.size())));
  const bool large_enough = std::any_of(some.views.begin(), some.views.end(), [](const View& view) {
    return std::max(view.camera.width, view.camera.height) >= kLeastSidePx;
  });
  if (!large_enough || mesh.vertices.empty()) return "";
  PairsOptions by_mesh = options;
  by_mesh.method = PairsMethod::kTuned;
  const Eigen::Vector3d middle = BoundingBox(mesh).center();
  double best = 0;
  std::string text;
  for (const bool about_middle : {false, true}) {
    for (const Eigen::Matrix3d& rotation : AxisRotations()) {
      const Eigen::Vector3d center = about_middle ? middle : Eigen::Vector3d::Zero();
      TriangleMesh turned = mesh;
      for (Eigen::Vector3d& vertex : turned.vertices) {
        vertex = center + rotation * (vertex - center);
      }
      const double fit = FitOf(some, turned, by_mesh);
      if (fit <= best) continue;
      best = fit;
      text = "with its axes turned " + std::string(about_middle ? "about its middle " : "") +
             "the mesh would fit: take " + AxesText(rotation) + " for its x, y, z";
    }
    if (best > 0) break;
  }
  return text;
}

}  // namespace burin
