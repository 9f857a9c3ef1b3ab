#include "core/scene/camera_similarity.h"

#include <glog/logging.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>
#include <limits>

namespace burin {
namespace {

constexpr int kMaxIterations = 50;
constexpr int kMaxHalvings = 12;
constexpr double kNoStepPx = 1e-9;      // stop when the step moves the points by less, RMS
constexpr double kNoStiffness = 1e-12;  // eigenvalues below this share of the largest hold nothing

using Vector7 = Eigen::Matrix<double, 7, 1>;
using Matrix7 = Eigen::Matrix<double, 7, 7>;
using Views = std::vector<Camera>;
using Points = std::vector<std::vector<Eigen::Vector3d>>;
using Sightings = std::vector<std::vector<Sighting>>;

double Energy(const CameraErrors& errors) { return errors.views * errors.rms_px * errors.rms_px; }

// Mean orientation, and mean and spread of the centres, of the views with points.
Similarity Start(const Views& first, const Views& second, const Sightings& sightings) {
  Eigen::Vector3d mean_first = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_second = Eigen::Vector3d::Zero();
  Eigen::Matrix3d turn = Eigen::Matrix3d::Zero();
  int count = 0;
  for (size_t v = 0; v < sightings.size(); ++v) {
    if (sightings[v].empty()) continue;
    ++count;
    mean_first += first[v].Center();
    mean_second += second[v].Center();
    turn += second[v].rotation.transpose() * first[v].rotation;
  }
  mean_first /= count;
  mean_second /= count;
  double spread_first = 0;
  double spread_second = 0;
  for (size_t v = 0; v < sightings.size(); ++v) {
    if (sightings[v].empty()) continue;
    spread_first += (first[v].Center() - mean_first).squaredNorm();
    spread_second += (second[v].Center() - mean_second).squaredNorm();
  }
  Similarity start;
  // The rotation nearest to the sum: never a reflection.
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(turn, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  start.rotation =
      svd.matrixU() * Eigen::Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
  const double ratio = std::sqrt(spread_second / spread_first);
  if (std::isfinite(ratio) && ratio > 0) start.scale = ratio;
  start.translation = mean_second - start.scale * (start.rotation * mean_first);
  return start;
}

// Small motions about the centroid of the moved points: x = centre + d goes to centre + d + w x d / extent + t
// + g d / extent.
class Increments {
 public:
  Increments(const Sightings& sightings, const Similarity& motion) {
    int count = 0;
    for (const std::vector<Sighting>& of_view : sightings) {
      for (const Sighting& seen : of_view) centre_ += motion * seen.point;
      count += static_cast<int>(of_view.size());
    }
    centre_ /= count;
    double squares = 0;
    for (const std::vector<Sighting>& of_view : sightings) {
      for (const Sighting& seen : of_view) squares += (motion * seen.point - centre_).squaredNorm();
    }
    if (squares > 0) extent_ = std::sqrt(squares / count);
  }

  // The derivative of image points by (w, t, g), from that by the point.
  Eigen::Matrix<double, 2, 7> Derivative(const Eigen::Matrix<double, 2, 3>& by_point,
                                         const Eigen::Vector3d& point) const {
    const Eigen::Vector3d offset = (point - centre_) / extent_;
    Eigen::Matrix<double, 2, 7> rows;
    for (int k = 0; k < 2; ++k) {
      const Eigen::Vector3d n = by_point.row(k);
      rows.row(k) << offset.cross(n).transpose(), n.transpose(), n.dot(offset);
    }
    return rows;
  }

  Similarity Motion(const Vector7& step) const {
    Similarity motion;
    const double angle = step.head<3>().norm() / extent_;
    if (angle > 0) {
      motion.rotation = Eigen::AngleAxisd(angle, step.head<3>().normalized()).toRotationMatrix();
    }
    motion.scale = std::exp(step[6] / extent_);
    motion.translation = centre_ - motion.scale * (motion.rotation * centre_) + step.segment<3>(3);
    return motion;
  }

 private:
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  double extent_ = 1;
};

// The Gauss-Newton step, and how far it moves the points, RMS in pixels. Nothing along directions without stiffness.
Vector7 Step(const Views& second, const Sightings& sightings, const Similarity& motion,
             const Increments& increments, double* move_px) {
  Matrix7 stiffness = Matrix7::Zero();
  Vector7 force = Vector7::Zero();
  int views = 0;
  for (size_t v = 0; v < sightings.size(); ++v) {
    if (sightings[v].empty()) continue;
    ++views;
    Matrix7 view_stiffness = Matrix7::Zero();
    Vector7 view_force = Vector7::Zero();
    for (const Sighting& seen : sightings[v]) {
      const Eigen::Vector3d moved = motion * seen.point;
      if (second[v].Depth(moved) <= 0) continue;
      const Eigen::Vector2d error = second[v].Project(moved) - seen.pixel;
      const Eigen::Vector3d in_camera = second[v].rotation * moved + second[v].translation;
      const auto rows = increments.Derivative(second[v].ProjectByPoint(in_camera), moved);
      view_stiffness += rows.transpose() * rows;
      view_force -= rows.transpose() * error;
    }
    stiffness += view_stiffness / static_cast<double>(sightings[v].size());
    force += view_force / static_cast<double>(sightings[v].size());
  }
  const Eigen::SelfAdjointEigenSolver<Matrix7> eigen(stiffness);
  const double least = kNoStiffness * eigen.eigenvalues()[6];
  Vector7 step = Vector7::Zero();
  for (int k = 0; k < 7; ++k) {
    if (!(eigen.eigenvalues()[k] > least)) continue;
    const Vector7 axis = eigen.eigenvectors().col(k);
    step += axis * (axis.dot(force) / eigen.eigenvalues()[k]);
  }
  *move_px = std::sqrt(step.dot(stiffness * step) / views);
  return step;
}

}  // namespace

Sightings SightingsOf(const Views& cameras, const Points& points) {
  CHECK_EQ(cameras.size(), points.size());
  Sightings sightings(points.size());
  for (size_t v = 0; v < points.size(); ++v) {
    for (const Eigen::Vector3d& point : points[v]) {
      sightings[v].push_back({point, cameras[v].Project(point)});
    }
  }
  return sightings;
}

CameraErrors MeasureCameraErrors(const Views& second, const Sightings& sightings,
                                 const Similarity& motion) {
  CHECK_EQ(second.size(), sightings.size());
  CameraErrors errors;
  errors.view_px.assign(sightings.size(), std::numeric_limits<double>::quiet_NaN());
  errors.behind.assign(sightings.size(), 0);
  double sum = 0;
  for (size_t v = 0; v < sightings.size(); ++v) {
    if (sightings[v].empty()) continue;
    double squares = 0;
    for (const Sighting& seen : sightings[v]) {
      const Eigen::Vector3d moved = motion * seen.point;
      if (second[v].Depth(moved) > 0) {
        squares += (second[v].Project(moved) - seen.pixel).squaredNorm();
      } else {
        squares += Eigen::Vector2d(second[v].width, second[v].height).squaredNorm();
        ++errors.behind[v];
      }
    }
    const double mean = squares / static_cast<double>(sightings[v].size());
    errors.view_px[v] = std::sqrt(mean);
    sum += mean;
    ++errors.views;
  }
  if (errors.views > 0) errors.rms_px = std::sqrt(sum / errors.views);
  return errors;
}

bool FitCameraSimilarity(const Views& first, const Views& second, const Sightings& sightings,
                         CameraSimilarity* fit, std::string* error) {
  CHECK_EQ(first.size(), sightings.size());
  *fit = CameraSimilarity();
  fit->errors = MeasureCameraErrors(second, sightings, fit->second_from_first);
  size_t count = 0;
  for (const std::vector<Sighting>& of_view : sightings) count += of_view.size();
  if (count < 3) {
    *error = "camera similarity: " + std::to_string(count) + " surface points in " +
             std::to_string(sightings.size()) + " views, at least 3 needed";
    return false;
  }
  const auto accept = [&](const Similarity& trial) {
    CameraErrors errors = MeasureCameraErrors(second, sightings, trial);
    if (!(Energy(errors) < Energy(fit->errors))) return false;
    fit->second_from_first = trial;
    fit->errors = std::move(errors);
    return true;
  };
  accept(Start(first, second, sightings));
  while (fit->iterations < kMaxIterations) {
    const Similarity from = fit->second_from_first;
    const Increments increments(sightings, from);
    double move_px = 0;
    const Vector7 step = Step(second, sightings, from, increments, &move_px);
    if (move_px <= kNoStepPx) break;
    double share = 1;
    int halvings = 0;
    while (!accept(increments.Motion(share * step) * from) && ++halvings < kMaxHalvings) share /= 2;
    if (halvings == kMaxHalvings) break;
    ++fit->iterations;
  }
  // Products of many rotations drift from orthogonality by rounding.
  Similarity& motion = fit->second_from_first;
  motion.rotation = Eigen::Quaterniond(motion.rotation).normalized().toRotationMatrix();
  fit->errors = MeasureCameraErrors(second, sightings, motion);
  return true;
}

bool FitCameraSimilarity(const Views& first, const Views& second, const Points& points,
                         CameraSimilarity* fit, std::string* error) {
  return FitCameraSimilarity(first, second, SightingsOf(first, points), fit, error);
}

}  // namespace burin
