#include "core/mesh/alignment.h"

#include <glog/logging.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "core/support/parallel.h"

namespace burin {
namespace {

struct PlanePair {
  Eigen::Vector3d point;   // moved
  Eigen::Vector3d target;  // its counterpart
  Eigen::Vector3d normal;  // zero when there is no pair
  double residual = 0;     // n.(x - q)
};

std::vector<PlanePair> FindPairs(const std::vector<Eigen::Vector3d>& points,
                                 const Similarity& motion, const PlaneOf& plane_of) {
  std::vector<PlanePair> all(points.size());
  ParallelFor(static_cast<int>(points.size()), 512, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      PlanePair& pair = all[k];
      pair.point = motion * points[k];
      pair.normal.setZero();
      if (!plane_of(k, pair.point, &pair.target, &pair.normal)) pair.normal.setZero();
      pair.residual = pair.normal.isZero(0) ? 0 : pair.normal.dot(pair.point - pair.target);
    }
  });
  std::vector<PlanePair> found;
  for (const PlanePair& pair : all) {
    if (!pair.normal.isZero(0)) found.push_back(pair);
  }
  return found;
}

double PlaneError(const PlanePair& pair) { return std::abs(pair.residual); }
double PointError(const PlanePair& pair) { return (pair.point - pair.target).norm(); }

// Removes the pairs with the largest errors; those at the limit stay, in any number.
template <typename ErrorOf>
void Trim(double keep_fraction, size_t min_count, const ErrorOf& error_of,
          std::vector<PlanePair>* pairs) {
  const size_t keep = std::max<size_t>(
      min_count, static_cast<size_t>(keep_fraction * static_cast<double>(pairs->size())));
  if (keep >= pairs->size()) return;
  std::vector<double> sizes;
  for (const PlanePair& pair : *pairs) sizes.push_back(error_of(pair));
  std::nth_element(sizes.begin(), sizes.begin() + (keep - 1), sizes.end());
  const double limit = sizes[keep - 1];
  pairs->erase(std::remove_if(pairs->begin(), pairs->end(),
                              [&](const PlanePair& pair) { return error_of(pair) > limit; }),
               pairs->end());
}

// Minimiser of sum (residual + n.(w x d + t + g d))^2, d = (x - centre)/extent, over (w, t, g), all
// in world units; N = 6 leaves out the growth g, which is then 0. Minimum norm over directions with
// no stiffness.
template <int N>
Eigen::Matrix<double, 7, 1> SolveStep(const std::vector<PlanePair>& pairs,
                                      const Eigen::Vector3d& centre, double extent) {
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;
  Matrix stiffness = Matrix::Zero();
  Vector force = Vector::Zero();
  for (const PlanePair& pair : pairs) {
    const Eigen::Vector3d offset = (pair.point - centre) / extent;
    Vector row;
    row.template head<3>() = offset.cross(pair.normal);
    row.template segment<3>(3) = pair.normal;
    if (N == 7) row[N - 1] = pair.normal.dot(offset);
    stiffness += row * row.transpose();
    force -= pair.residual * row;
  }
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(stiffness);
  Vector step = Vector::Zero();
  const double smallest = 1e-8 * eigen.eigenvalues()[N - 1];
  for (int k = 0; k < N; ++k) {
    if (eigen.eigenvalues()[k] <= smallest) continue;
    const Vector axis = eigen.eigenvectors().col(k);
    step += axis * (axis.dot(force) / eigen.eigenvalues()[k]);
  }
  Eigen::Matrix<double, 7, 1> all = Eigen::Matrix<double, 7, 1>::Zero();
  all.head<N>() = step;
  return all;
}

// What the kept pairs ask for next, and a bound on how far it moves any of them.
struct Increment {
  Similarity motion;
  double move = 0;
};

bool PointIncrement(const std::vector<PlanePair>& pairs, Increment* increment, std::string* error) {
  std::vector<Eigen::Vector3d> source;
  std::vector<Eigen::Vector3d> target;
  for (const PlanePair& pair : pairs) {
    source.push_back(pair.point);
    target.push_back(pair.target);
  }
  if (!FitSimilarity(source, target, &increment->motion, error)) return false;
  for (const Eigen::Vector3d& point : source) {
    increment->move = std::max(increment->move, (increment->motion * point - point).norm());
  }
  return true;
}

Increment PlaneIncrement(const std::vector<PlanePair>& pairs, const Eigen::Vector3d& centre,
                         double extent, bool scale) {
  const Eigen::Matrix<double, 7, 1> step =
      scale ? SolveStep<7>(pairs, centre, extent) : SolveStep<6>(pairs, centre, extent);
  Increment increment;
  Similarity& motion = increment.motion;
  const double angle = step.head<3>().norm() / extent;
  if (angle > 0) {
    motion.rotation = Eigen::AngleAxisd(angle, step.head<3>().normalized()).toRotationMatrix();
  }
  motion.scale = std::max(0.5, 1 + step[6] / extent);  // a scale cannot become negative
  motion.translation = centre - motion.scale * (motion.rotation * centre) + step.segment<3>(3);
  increment.move = step.head<3>().norm() + step.segment<3>(3).norm() + std::abs(step[6]);
  return increment;
}

}  // namespace

TriangleMesh Moved(const TriangleMesh& mesh, const Similarity& motion) {
  TriangleMesh moved = mesh;
  for (Eigen::Vector3d& vertex : moved.vertices) vertex = motion * vertex;
  return moved;
}

bool FitSimilarity(const std::vector<Eigen::Vector3d>& source,
                   const std::vector<Eigen::Vector3d>& target, Similarity* target_from_source,
                   std::string* error) {
  CHECK_EQ(source.size(), target.size());
  if (source.size() < 3) {
    *error = "similarity: " + std::to_string(source.size()) + " pairs of points, at least 3 needed";
    return false;
  }
  const auto columns = [](const std::vector<Eigen::Vector3d>& points) {
    return Eigen::Map<const Eigen::Matrix3Xd>(points[0].data(), 3,
                                              static_cast<Eigen::Index>(points.size()));
  };
  const auto from = columns(source);
  const auto to = columns(target);
  // umeyama() returns some rotation for points on a line, and does not say so.
  const Eigen::Matrix3d covariance =
      (to.colwise() - to.rowwise().mean()) * (from.colwise() - from.rowwise().mean()).transpose();
  const Eigen::Vector3d singular = covariance.jacobiSvd().singularValues();  // descending
  if (!(singular[1] > 1e-12 * singular[0])) {
    *error = "similarity: the points coincide or lie on a line";
    return false;
  }
  const Eigen::Matrix4d fit = Eigen::umeyama(from, to);
  const Eigen::Matrix3d scaled_rotation = fit.topLeftCorner<3, 3>();
  target_from_source->scale = scaled_rotation.col(0).norm();
  target_from_source->rotation = scaled_rotation / target_from_source->scale;
  target_from_source->translation = fit.topRightCorner<3, 1>();
  return true;
}

bool AlignToSurface(const std::vector<Eigen::Vector3d>& points, const PlaneOf& plane_of,
                    const AlignmentOptions& options, Alignment* alignment, std::string* error) {
  *alignment = Alignment();
  const size_t min_pairs = options.scale ? 7 : 6;
  bool by_points = options.scale;
  while (alignment->iterations < options.max_iterations && !alignment->converged) {
    std::vector<PlanePair> pairs = FindPairs(points, alignment->motion, plane_of);
    if (by_points) {
      Trim(options.keep_fraction, min_pairs, PointError, &pairs);
    } else {
      Trim(options.keep_fraction, min_pairs, PlaneError, &pairs);
    }
    alignment->pair_count = static_cast<int>(pairs.size());
    if (pairs.size() < min_pairs) {
      *error = "alignment: " + std::to_string(pairs.size()) +
               " points have a counterpart in reach, at least " + std::to_string(min_pairs) +
               " are needed";
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
      *error = "alignment: all points coincide";
      return false;
    }

    Increment increment;
    if (by_points) {
      if (!PointIncrement(pairs, &increment, error)) return false;
      by_points = increment.move > options.point_step * extent &&
                  alignment->iterations + 1 < options.max_point_iterations;
    } else {
      increment = PlaneIncrement(pairs, centre, extent, options.scale);
      alignment->converged = increment.move <= options.min_step * extent;
    }
    alignment->motion = increment.motion * alignment->motion;
    ++alignment->iterations;
  }
  // Products of many rotations drift from orthogonality by rounding.
  alignment->motion.rotation =
      Eigen::Quaterniond(alignment->motion.rotation).normalized().toRotationMatrix();
  return true;
}

}  // namespace burin
