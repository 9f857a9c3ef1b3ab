#include "core/evaluate/dtu_evaluation.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

#include "core/mesh/closest_point.h"
#include "core/mesh/point_thinning.h"
#include "core/mesh/surface_samples.h"
#include "core/support/error.h"
#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kGrain = 1024;
constexpr double kSamplesPerSquare = 4;
constexpr double kMaxSamples = 1e8;
constexpr double kMaxExtentInSpacings = 1e9;  // coordinates keep seven digits below the spacing

// Of the points that count: distance to the nearest of the others, negative beyond the cap.
std::vector<double> CappedDistances(const std::vector<Eigen::Vector3d>& points,
                                    const std::function<bool(const Eigen::Vector3d&)>& counts,
                                    const CloudDistance& others, double cap) {
  std::vector<Eigen::Vector3d> counted;
  for (const Eigen::Vector3d& point : points) {
    if (counts(point)) counted.push_back(point);
  }
  std::vector<double> distances(counted.size(), -1);
  ParallelFor(static_cast<int>(counted.size()), kGrain, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) others.Find(counted[k], cap, &distances[k]);
  });
  return distances;
}

std::string Text(double number) {
  char buffer[32];
  std::snprintf(buffer, sizeof(buffer), "%g", number);
  return buffer;
}

InputError SpacingError(double spacing, const std::string& reason) {
  return InputError("dtu.spacing: " + Text(spacing) + " world units: " + reason);
}

std::vector<Eigen::Vector3d> ThinnedWithin(const std::vector<Eigen::Vector3d>& points,
                                           double spacing, int seed, const std::string& name) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& point : points) box.extend(point);
  // From the origin: the rounding of coordinates grows with that distance.
  const double extent = std::max(box.min().lpNorm<Eigen::Infinity>(),  //
                                 box.max().lpNorm<Eigen::Infinity>());
  if (extent > kMaxExtentInSpacings * spacing) {
    throw SpacingError(spacing,
                       "too small for coordinates of the " + name + " up to " + Text(extent));
  }
  return Thinned(points, spacing, static_cast<std::uint64_t>(seed));
}

std::vector<Eigen::Vector3d> SurfacePoints(const TriangleMesh& mesh, double spacing, int seed,
                                           const std::string& name) {
  const double area = SurfaceArea(mesh);
  if (!(area > 0)) throw InputError("dtu: the " + name + " has no surface");
  const double count = std::ceil(kSamplesPerSquare * area / (spacing * spacing));
  if (count > kMaxSamples) {
    throw SpacingError(
        spacing, "the " + name + " of area " + Text(area) + " would need more than 1e8 samples");
  }
  const SurfaceSamples samples =
      SampleSurface(mesh, static_cast<int>(count), static_cast<std::uint64_t>(seed));
  return ThinnedWithin(samples.points, spacing, seed, name);
}

}  // namespace

void DtuOptions::Describe(OptionSet* set) {
  set->Add("dtu.run", &run, "Score by the DTU protocol too");
  set->Add("dtu.spacing", &spacing, "No two points of a set are nearer than this, in unit", 1e-12,
           1e12);
  set->Add("dtu.cap", &cap, "Points further from the other set are left out, in unit", 1e-12, 1e12);
  set->Add("dtu.mask", &mask,
           "Observability mask of the accuracy (JSON header); empty = everywhere");
  set->Add("dtu.plane", &plane,
           "Table plane of the completeness (file of four numbers); empty = everywhere");
}

DtuRegion ReadDtuRegion(const DtuOptions& options) {
  DtuRegion region;
  if (!options.run) {
    if (!options.mask.empty()) throw InputError("dtu.mask: needs dtu.run");
    if (!options.plane.empty()) throw InputError("dtu.plane: needs dtu.run");
    return region;
  }
  if (!options.mask.empty()) region.mask = ReadVoxelMask(options.mask);
  if (!options.plane.empty()) region.plane = ReadPlane(options.plane);
  return region;
}

std::optional<double> DtuEvaluation::Overall() const {
  if (accuracy.matched == 0 || completeness.matched == 0) return std::nullopt;
  return 0.5 * (accuracy.mean + completeness.mean);
}

DtuEvaluation CompareDtuPoints(const std::vector<Eigen::Vector3d>& mesh_points,
                               const std::vector<Eigen::Vector3d>& truth_points, double cap,
                               const DtuRegion& region) {
  DtuEvaluation evaluation;
  evaluation.cap = cap;
  evaluation.mesh_points = static_cast<std::int64_t>(mesh_points.size());
  evaluation.truth_points = static_cast<std::int64_t>(truth_points.size());
  evaluation.accuracy = StatisticsOf(CappedDistances(
      mesh_points,
      [&](const Eigen::Vector3d& point) { return !region.mask || region.mask->Contains(point); },
      CloudDistance(truth_points), cap));
  if (evaluation.accuracy.count == 0) {
    throw InputError("dtu.mask: none of the mesh's " + std::to_string(mesh_points.size()) +
                     " points is inside");
  }
  evaluation.completeness = StatisticsOf(CappedDistances(
      truth_points,
      [&](const Eigen::Vector3d& point) { return !region.plane || IsAbove(*region.plane, point); },
      CloudDistance(mesh_points), cap));
  if (evaluation.completeness.count == 0) {
    throw InputError("dtu.plane: none of the truth's " + std::to_string(truth_points.size()) +
                     " points is above it");
  }
  return evaluation;
}

DtuEvaluation EvaluateDtu(const TriangleMesh& mesh, const Truth& truth, const DtuOptions& options,
                          const DtuRegion& region, double unit, int seed) {
  CheckTruth(truth);
  const double spacing = options.spacing * unit;
  const std::vector<Eigen::Vector3d> mesh_points = SurfacePoints(mesh, spacing, seed, "mesh");
  const std::vector<Eigen::Vector3d> truth_points =
      truth.IsMesh() ? SurfacePoints(truth.mesh, spacing, seed, "truth")
                     : ThinnedWithin(truth.cloud.points, spacing, seed, "truth");
  DtuEvaluation evaluation =
      CompareDtuPoints(mesh_points, truth_points, options.cap * unit, region);
  evaluation.spacing = spacing;
  return evaluation;
}

}  // namespace burin
