#include "apps/run/single_precision.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace burin {
namespace {

constexpr double kVisible = 0.1;  // pixels
constexpr size_t kMostPoints = 5000;
constexpr double kFar = 1000;  // times the size of what is seen

bool Shows(const View& view, const Eigen::Vector3d& point) {
  return view.camera.Depth(point) > 0 && view.camera.Contains(view.camera.Project(point));
}

// The size of a pixel at the point, in the view that sees it sharpest; 0 where none sees it.
double Footprint(const Scene& scene, const Eigen::Vector3d& point) {
  double footprint = 0;
  for (const View& view : scene.views) {
    if (!Shows(view, point)) continue;
    const double size = view.camera.Footprint(point);
    footprint = footprint > 0 ? std::min(footprint, size) : size;
  }
  return footprint;
}

std::string Text(double value) {
  std::ostringstream text;
  text.precision(3);
  text << value;
  return text.str();
}

bool IsSingle(const TriangleMesh& mesh) {
  return std::all_of(mesh.vertices.begin(), mesh.vertices.end(), [](const Eigen::Vector3d& vertex) {
    return vertex == vertex.cast<float>().cast<double>();
  });
}

}  // namespace

std::string SinglePrecisionSteps(const Scene& scene, const std::vector<Eigen::Vector3d>& points) {
  std::vector<double> footprints;
  double largest = 0;
  const size_t stride = std::max<size_t>(1, points.size() / kMostPoints);
  for (size_t p = 0; p < points.size(); p += stride) {
    const double footprint = Footprint(scene, points[p]);
    if (!(footprint > 0)) continue;
    footprints.push_back(footprint);
    largest = std::max(largest, points[p].cwiseAbs().maxCoeff());
  }
  if (footprints.empty() || !(largest > 0)) return {};
  const auto middle = footprints.begin() + static_cast<std::ptrdiff_t>(footprints.size() / 2);
  std::nth_element(footprints.begin(), middle, footprints.end());
  const double step = std::ldexp(1.0, std::ilogb(largest) - std::numeric_limits<float>::digits + 1);
  if (step <= kVisible * *middle) return {};
  return "at " + Text(largest) + " single precision has steps of " + Text(step) + " units, " +
         Text(step / *middle) + " px";
}

std::string MeshPrecisionLine(const Scene& scene, const TriangleMesh& mesh) {
  if (!IsSingle(mesh)) return {};
  const std::string steps = SinglePrecisionSteps(scene, mesh.vertices);
  if (steps.empty()) return {};
  return "mesh: its coordinates are single precision: " + steps +
         " (export it in double precision, or around a local origin)";
}

std::string StrayPartLine(const Scene& scene, const TriangleMesh& mesh) {
  Eigen::AlignedBox3d seen;
  std::vector<char> is_seen(mesh.vertices.size(), 0);
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    const auto shows = [&](const View& view) { return Shows(view, mesh.vertices[v]); };
    if (std::none_of(scene.views.begin(), scene.views.end(), shows)) continue;
    is_seen[v] = 1;
    seen.extend(mesh.vertices[v]);
  }
  if (seen.isEmpty() || !(seen.diagonal().norm() > 0)) return {};
  double farthest = kFar * seen.diagonal().norm();
  Eigen::Vector3d where;
  bool found = false;
  for (const Eigen::Vector3i& face : mesh.faces) {
    if (is_seen[face[0]] != 0 || is_seen[face[1]] != 0 || is_seen[face[2]] != 0) continue;
    const double distance = seen.exteriorDistance(mesh.vertices[face[0]]);
    if (distance <= farthest) continue;
    farthest = distance;
    where = mesh.vertices[face[0]];
    found = true;
  }
  if (!found) return {};
  return "mesh: a part at (" + Text(where.x()) + ", " + Text(where.y()) + ", " + Text(where.z()) +
         ") is " + Text(farthest) + " units from what the views see, " +
         Text(farthest / seen.diagonal().norm()) + " times its size (a point that was never set?)";
}

}  // namespace burin
