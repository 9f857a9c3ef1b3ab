#include "selection/pair_terms.h"

#include <Eigen/Geometry>
#include <cmath>

namespace burin {
namespace {

// Angle between two vectors, degrees. atan2 is exact near 0 and 180 degrees, where acos is not.
double AngleDeg(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / M_PI;
}

}  // namespace

PointSight::PointSight(const Eigen::Vector3d& center, double focal_px, const Eigen::Vector3d& x,
                       const Eigen::Vector3d& n)
    : toward(center - x),
      distance(toward.norm()),
      rho(distance / focal_px),
      height(toward.dot(n)),
      normal_deg(AngleDeg(toward, n)) {}

double FocalPx(const Camera& camera) { return std::sqrt(camera.fx * camera.fy); }

double ParallaxDeg(const PointSight& i, const PointSight& j) {
  return AngleDeg(i.toward, j.toward);
}

double OrientedAngleDifferenceDeg(const PointSight& i, const PointSight& j, bool printed) {
  // The parts of the directions in the tangent plane.
  const double side = i.toward.dot(j.toward) - i.height * j.height;
  const double sign = side >= 0 ? 1 : -1;
  return printed ? sign * (i.normal_deg - j.normal_deg) / 2
                 : (i.normal_deg + sign * j.normal_deg) / 2;
}

double ResolutionDiscrepancy(const PointSight& i, const PointSight& j, bool printed) {
  return std::abs(i.rho - j.rho) / (printed ? i.distance : i.rho);
}

double GaussianEnergy(double value, double reference, double sigma) {
  const double z = (value - reference) / sigma;
  return -std::exp(-0.5 * z * z);
}

double SymmetryDeg(const PairMeasure& measure, const BpvOptions& options) {
  return measure.symmetry_deg[options.printed_symmetry ? 1 : 0][options.signed_symmetry ? 1 : 0];
}

PairEnergies EvaluatePair(const PairMeasure& measure, double seen, const BpvOptions& options) {
  PairEnergies energies;
  if (measure.area <= 0) return energies;
  energies.parallax = GaussianEnergy(measure.parallax_deg, options.reference_parallax_deg,
                                     options.sigma_parallax_deg);
  energies.overlap = -measure.area / (options.overlap_of_image ? 1 : seen);
  energies.symmetry = GaussianEnergy(SymmetryDeg(measure, options), 0, options.sigma_symmetry_deg);
  energies.resolution =
      GaussianEnergy(options.printed_resolution ? measure.resolution_printed : measure.resolution,
                     0, options.sigma_resolution);
  if (options.use_parallax) energies.total += options.weight_parallax * energies.parallax;
  if (options.use_overlap) energies.total += options.weight_overlap * energies.overlap;
  if (options.use_symmetry) energies.total += options.weight_symmetry * energies.symmetry;
  if (options.use_resolution) energies.total += options.weight_resolution * energies.resolution;
  return energies;
}

}  // namespace burin
