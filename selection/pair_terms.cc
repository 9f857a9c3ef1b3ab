#include "selection/pair_terms.h"

#include <Eigen/Geometry>
#include <cmath>

namespace burin {
namespace {

// Angle between two vectors, degrees. atan2 is exact near 0 and 180 degrees, where acos is not.
double AngleDeg(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / M_PI;
}

double Rho(const Camera& camera, const Eigen::Vector3d& x) {
  return (camera.Center() - x).norm() / std::sqrt(camera.fx * camera.fy);
}

}  // namespace

double ParallaxDeg(const Eigen::Vector3d& center_i, const Eigen::Vector3d& center_j,
                   const Eigen::Vector3d& x) {
  return AngleDeg(center_i - x, center_j - x);
}

double OrientedAngleDifferenceDeg(const Eigen::Vector3d& center_i, const Eigen::Vector3d& center_j,
                                  const Eigen::Vector3d& x, const Eigen::Vector3d& n,
                                  bool printed) {
  const Eigen::Vector3d to_i = center_i - x;
  const Eigen::Vector3d to_j = center_j - x;
  const double angle_i = AngleDeg(to_i, n);
  const double angle_j = AngleDeg(to_j, n);
  // The parts of the directions in the tangent plane.
  const double side = to_i.dot(to_j) - to_i.dot(n) * to_j.dot(n);
  const double sign = side >= 0 ? 1 : -1;
  return printed ? sign * (angle_i - angle_j) / 2 : (angle_i + sign * angle_j) / 2;
}

double ResolutionDiscrepancy(const Camera& camera_i, const Camera& camera_j,
                             const Eigen::Vector3d& x, bool printed) {
  const double rho_i = Rho(camera_i, x);
  const double difference = std::abs(rho_i - Rho(camera_j, x));
  return difference / (printed ? (camera_i.Center() - x).norm() : rho_i);
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
