#include "core/rigid_alignment.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/parallel.h"

namespace burin {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

struct PlanePair {
  Eigen::Vector3d point;   // moved
  Eigen::Vector3d normal;  // zero when there is no pair
  double residual = 0;     // n.(x - q)
};

std::vector<PlanePair> FindPairs(const std::vector<Eigen::Vector3d>& points,
                                 const RigidMotion& motion, const PlaneOf& plane_of) {
  std::vector<PlanePair> all(points.size());
  ParallelFor(static_cast<int>(points.size()), 512, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      Eigen::Vector3d counterpart;
      PlanePair& pair = all[k];
      pair.point = motion * points[k];
      pair.normal.setZero();
      if (!plane_of(k, pair.point, &counterpart, &pair.normal)) pair.normal.setZero();
      pair.residual = pair.normal.isZero(0) ? 0 : pair.normal.dot(pair.point - counterpart);
    }
  });
  std::vector<PlanePair> found;
  for (const PlanePair& pair : all) {
    if (!pair.normal.isZero(0)) found.push_back(pair);
  }
  return found;
}

// Removes the pairs with the largest residuals; those at the limit stay, in any number.
void Trim(double keep_fraction, std::vector<PlanePair>* pairs) {
  const size_t keep =
      std::max<size_t>(6, static_cast<size_t>(keep_fraction * static_cast<double>(pairs->size())));
  if (keep >= pairs->size()) return;
  std::vector<double> sizes;
  for (const PlanePair& pair : *pairs) sizes.push_back(std::abs(pair.residual));
  std::nth_element(sizes.begin(), sizes.begin() + (keep - 1), sizes.end());
  const double limit = sizes[keep - 1];
  pairs->erase(
      std::remove_if(pairs->begin(), pairs->end(),
                     [&](const PlanePair& pair) { return std::abs(pair.residual) > limit; }),
      pairs->end());
}

// Minimiser of sum (residual + n.(w x (x - centre)/extent + t))^2 over (w, t), both in world units;
// minimum norm over directions with no stiffness.
Vector6d SolveStep(const std::vector<PlanePair>& pairs, const Eigen::Vector3d& centre,
                   double extent) {
  Matrix6d stiffness = Matrix6d::Zero();
  Vector6d force = Vector6d::Zero();
  for (const PlanePair& pair : pairs) {
    Vector6d row;
    row << ((pair.point - centre) / extent).cross(pair.normal), pair.normal;
    stiffness += row * row.transpose();
    force -= pair.residual * row;
  }
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(stiffness);
  Vector6d step = Vector6d::Zero();
  const double smallest = 1e-8 * eigen.eigenvalues()[5];
  for (int k = 0; k < 6; ++k) {
    if (eigen.eigenvalues()[k] <= smallest) continue;
    const Vector6d axis = eigen.eigenvectors().col(k);
    step += axis * (axis.dot(force) / eigen.eigenvalues()[k]);
  }
  return step;
}

}  // namespace

double RigidMotion::AngleDeg() const {
  // atan2 of (2 sin, 2 cos): exact for small angles, where acos of the trace loses half the digits.
  const Eigen::Vector3d twice_sine(rotation(2, 1) - rotation(1, 2), rotation(0, 2) - rotation(2, 0),
                                   rotation(1, 0) - rotation(0, 1));
  return std::atan2(twice_sine.norm(), rotation.trace() - 1) * 180 / M_PI;
}

bool AlignPointsToPlanes(const std::vector<Eigen::Vector3d>& points, const PlaneOf& plane_of,
                         const AlignmentOptions& options, Alignment* alignment,
                         std::string* error) {
  *alignment = Alignment();
  for (; alignment->iterations < options.max_iterations; ++alignment->iterations) {
    std::vector<PlanePair> pairs = FindPairs(points, alignment->motion, plane_of);
    Trim(options.keep_fraction, &pairs);
    alignment->pair_count = static_cast<int>(pairs.size());
    if (pairs.size() < 6) {
      *error = "rigid fit: " + std::to_string(pairs.size()) +
               " points have a counterpart in reach, at least 6 are needed";
      return false;
    }
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    double squares = 0;
    for (const PlanePair& pair : pairs) {
      centre += pair.point;
      squares += pair.residual * pair.residual;
    }
    centre /= static_cast<double>(pairs.size());
    alignment->rmse = std::sqrt(squares / static_cast<double>(pairs.size()));
    double extent = 0;
    for (const PlanePair& pair : pairs) extent = std::max(extent, (pair.point - centre).norm());
    if (!(extent > 0)) {
      *error = "rigid fit: all points coincide";
      return false;
    }

    const Vector6d step = SolveStep(pairs, centre, extent);
    const double angle = step.head<3>().norm() / extent;
    RigidMotion increment;
    if (angle > 0) {
      increment.rotation = Eigen::AngleAxisd(angle, step.head<3>().normalized()).toRotationMatrix();
    }
    increment.translation = centre - increment.rotation * centre + step.tail<3>();
    alignment->motion = increment * alignment->motion;
    if (step.head<3>().norm() + step.tail<3>().norm() <= options.min_step * extent) {
      alignment->converged = true;
      ++alignment->iterations;
      break;
    }
  }
  // Products of many rotations drift from orthogonality by rounding.
  alignment->motion.rotation =
      Eigen::Quaterniond(alignment->motion.rotation).normalized().toRotationMatrix();
  return true;
}

}  // namespace burin
