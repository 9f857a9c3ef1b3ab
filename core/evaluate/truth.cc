#include "core/evaluate/truth.h"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "core/mesh/mesh_io.h"
#include "core/mesh/surface_samples.h"
#include "core/support/error.h"

namespace burin {
namespace {

constexpr double kShareInside = 0.98;  // of the points that say how large a truth is
constexpr int kDiameterSamples = 50000;

using Points = std::vector<Eigen::Vector3d>;

// Radius of the ball about `centre` that holds kShareInside of the points.
double RadiusAbout(const Eigen::Vector3d& centre, const Points& points) {
  std::vector<double> radii;
  radii.reserve(points.size());
  for (const Eigen::Vector3d& point : points) radii.push_back((point - centre).norm());
  const auto outermost = radii.begin() + static_cast<std::int64_t>(
                                             kShareInside * static_cast<double>(radii.size() - 1));
  std::nth_element(radii.begin(), outermost, radii.end());
  return *outermost;
}

// Mean of the points within `radius` of `centre`.
Eigen::Vector3d MeanWithin(const Points& points, const Eigen::Vector3d& centre, double radius) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  std::int64_t count = 0;
  for (const Eigen::Vector3d& point : points) {
    if ((point - centre).norm() > radius) continue;
    sum += point;
    ++count;
  }
  return sum / static_cast<double>(count);
}

// A PLY header declares faces.
bool PlyHasFaces(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string line;
  // Headers are short; a file without one must not be read to its end.
  for (int k = 0; k < 1000 && std::getline(file, line); ++k) {
    std::istringstream words(line);
    std::string keyword, element;
    long long count = 0;
    words >> keyword;
    if (keyword == "end_header") break;
    if (keyword == "element" && words >> element >> count && element == "face") return count > 0;
  }
  return false;
}

}  // namespace

Truth ReadTruth(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char letter) { return std::tolower(letter); });
  Truth truth;
  if (extension == ".ply" && !PlyHasFaces(path)) {
    truth.cloud = ReadPointCloud(path);
  } else {
    truth.mesh = ReadMesh(path);
  }
  return truth;
}

double DiameterOf(const Truth& truth) {
  Points samples;
  if (truth.IsMesh()) samples = SampleSurface(truth.mesh, kDiameterSamples).points;
  const Points& points = truth.IsMesh() ? samples : truth.cloud.points;
  if (points.empty()) return 0;
  const Eigen::Vector3d middle =
      MeanWithin(points, points[0], std::numeric_limits<double>::infinity());
  const Eigen::Vector3d centre = MeanWithin(points, middle, RadiusAbout(middle, points));
  return 2 * RadiusAbout(centre, points);
}

void CheckTruth(const Truth& truth) {
  if (truth.IsMesh()) return;
  if (truth.cloud.points.empty()) throw InputError("evaluation: the truth has no points");
  if (!truth.cloud.normals.empty() && truth.cloud.normals.size() != truth.cloud.points.size()) {
    throw InputError("evaluation: the truth has " + std::to_string(truth.cloud.points.size()) +
                     " points and " + std::to_string(truth.cloud.normals.size()) + " normals");
  }
}

}  // namespace burin
