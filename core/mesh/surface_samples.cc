#include "core/mesh/surface_samples.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/support/parallel.h"

namespace burin {
namespace {

// splitmix64's output function: counter to a number in [0, 1).
double UnitFromCounter(std::uint64_t counter) {
  std::uint64_t bits = (counter + 1) * 0x9E3779B97F4A7C15ULL;
  bits = (bits ^ (bits >> 30)) * 0xBF58476D1CE4E5B9ULL;
  bits = (bits ^ (bits >> 27)) * 0x94D049BB133111EBULL;
  bits ^= bits >> 31;
  return static_cast<double>(bits >> 11) * 0x1.0p-53;
}

double Fraction(double number) { return number - std::floor(number); }

}  // namespace

double SurfaceArea(const TriangleMesh& mesh) {
  double area = 0;
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    area += 0.5 * FaceAreaNormal(mesh, static_cast<int>(f)).norm();
  }
  return area;
}

SurfaceSamples SampleSurface(const TriangleMesh& mesh, int count, std::uint64_t seed) {
  SurfaceSamples samples;
  std::vector<double> area_up_to(mesh.faces.size());
  double total = 0;
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    total += 0.5 * FaceAreaNormal(mesh, static_cast<int>(f)).norm();
    area_up_to[f] = total;
  }
  if (!(total > 0) || count <= 0) return samples;
  samples.points.resize(count);
  samples.normals.resize(count);
  samples.faces.resize(count);

  constexpr double kPlastic = 1.32471795724474602596;  // root of g^3 = g + 1
  const double offset = UnitFromCounter(3 * seed);
  const double offset_s = UnitFromCounter(3 * seed + 1);
  const double offset_t = UnitFromCounter(3 * seed + 2);
  ParallelFor(count, 4096, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      const double target = total * ((k + offset) / count);
      // The first face whose running sum exceeds the target: never one without area.
      auto found = std::upper_bound(area_up_to.begin(), area_up_to.end(), target);
      if (found == area_up_to.end()) {
        found = std::lower_bound(area_up_to.begin(), area_up_to.end(), total);
      }
      const int face = static_cast<int>(found - area_up_to.begin());
      double s = Fraction(offset_s + k / kPlastic);
      double t = Fraction(offset_t + k / (kPlastic * kPlastic));
      if (s + t > 1) {
        s = 1 - s;
        t = 1 - t;
      }
      const Eigen::Vector3i& index = mesh.faces[face];
      const Eigen::Vector3d& origin = mesh.vertices[index[0]];
      samples.points[k] =
          origin + s * (mesh.vertices[index[1]] - origin) + t * (mesh.vertices[index[2]] - origin);
      samples.normals[k] = FaceAreaNormal(mesh, face).normalized();
      samples.faces[k] = face;
    }
  });
  return samples;
}

}  // namespace burin
