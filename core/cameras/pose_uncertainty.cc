#include "core/cameras/pose_uncertainty.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/cameras/bundle.h"

namespace burin {
namespace {

using Matrix26 = Eigen::Matrix<double, 2, 6>;
using Matrix23 = Eigen::Matrix<double, 2, 3>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kHeld = 1e6;  // 1 / variance of each freedom, square pixels

Eigen::Matrix3d Cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// Derivatives of the image point, pixels, by rotation (a turn in the camera's frame) and centre, and by the point.
void Derivatives(const Camera& camera, const Eigen::Vector3d& point, Matrix26* by_pose,
                 Matrix23* by_point) {
  const Eigen::Vector3d seen = camera.rotation * point + camera.translation;
  *by_point = camera.ProjectByPoint(seen);
  by_pose->leftCols<3>() = -*by_point * camera.rotation.transpose() * Cross(seen);
  by_pose->rightCols<3>() = -*by_point;
}

// Of the camera's pose by a turn, a shift and a growth of the world about `middle`.
Eigen::Matrix<double, 6, 7> Freedoms(const Camera& camera, const Eigen::Vector3d& middle) {
  const Eigen::Vector3d from = camera.Center() - middle;
  Eigen::Matrix<double, 6, 7> z = Eigen::Matrix<double, 6, 7>::Zero();
  z.topLeftCorner<3, 3>() = -camera.rotation;
  z.bottomLeftCorner<3, 3>() = -Cross(from);
  z.block<3, 3>(3, 3).setIdentity();
  z.bottomRightCorner<3, 1>() = from;
  return z;
}

// M Z of the views that have a place, in columns of one size: a turn, a shift and a growth have different units.
Eigen::MatrixXd HeldFreedoms(const std::vector<Camera>& cameras, const std::vector<int>& views,
                             const std::vector<std::vector<Eigen::Vector3d>>& surface,
                             const std::vector<int>& place, const std::vector<Matrix6>& moves,
                             int unknowns) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  size_t points = 0;
  for (const int v : views) {
    for (const Eigen::Vector3d& point : surface[v]) middle += point;
    points += surface[v].size();
  }
  middle /= static_cast<double>(std::max<size_t>(1, points));
  Eigen::MatrixXd freedoms = Eigen::MatrixXd::Zero(unknowns, 7);
  Eigen::MatrixXd held = Eigen::MatrixXd::Zero(unknowns, 7);
  for (const int v : views) {
    if (place[v] < 0) continue;
    freedoms.middleRows<6>(place[v]) = Freedoms(cameras[v], middle);
    held.middleRows<6>(place[v]) = moves[v] * freedoms.middleRows<6>(place[v]);
  }
  for (int k = 0; k < 7; ++k) {
    const double squared = freedoms.col(k).dot(held.col(k));
    if (squared > 0) held.col(k) /= std::sqrt(squared);
  }
  return held;
}

}  // namespace

std::vector<double> PoseDeviations(const std::vector<Camera>& cameras, const MeshTracks& tracks,
                                   double sigma, double loss_px,
                                   const std::vector<std::vector<Eigen::Vector3d>>& surface) {
  const size_t count = cameras.size();
  std::vector<double> deviations(count, std::numeric_limits<double>::quiet_NaN());
  std::vector<int> place(count, -1);  // of the views that have measurements
  int unknowns = 0;
  for (size_t v = 0; v < count; ++v) {
    if (tracks.groups.of_view[v] < 0 || surface[v].empty()) continue;
    place[v] = unknowns;
    unknowns += 6;
  }
  if (unknowns == 0 || unknowns > 6 * kMostViewsWithDeviations || !(sigma > 0)) return deviations;
  Eigen::MatrixXd reduced = Eigen::MatrixXd::Zero(unknowns, unknowns);
  for (size_t p = 0; p < tracks.tracks.PointCount(); ++p) {
    const Tracks::Range track = tracks.tracks.Of(p);
    Eigen::Vector3d point;
    if (!Triangulate(cameras, track, tracks.pixel, loss_px, &point)) continue;
    Eigen::Matrix3d of_point = Eigen::Matrix3d::Zero();
    std::vector<std::pair<int, Eigen::Matrix<double, 6, 3>>> couplings;
    for (const Measurement& measured : track) {
      const Camera& camera = cameras[measured.view];
      const double pixel = tracks.ScaleOf(p, measured.view);
      Matrix26 by_pose;
      Matrix23 by_point;
      Derivatives(camera, point, &by_pose, &by_point);
      const double squared =
          (camera.Project(point) - measured.image_point).squaredNorm() / (pixel * pixel);
      const double scale = 1 / (pixel * sigma * std::sqrt(1 + squared / (loss_px * loss_px)));
      by_pose *= scale;
      by_point *= scale;
      of_point += by_point.transpose() * by_point;
      const int at = place[measured.view];
      if (at < 0) continue;
      reduced.block<6, 6>(at, at) += by_pose.transpose() * by_pose;
      couplings.emplace_back(at, by_pose.transpose() * by_point);
    }
    const Eigen::Matrix3d inverse = of_point.inverse();
    if (!inverse.allFinite()) continue;
    for (const auto& [a, of_a] : couplings) {
      for (const auto& [b, of_b] : couplings) {
        reduced.block<6, 6>(a, b) -= of_a * inverse * of_b.transpose();
      }
    }
  }
  std::vector<Matrix6> moves(count, Matrix6::Zero());
  for (size_t v = 0; v < count; ++v) {
    if (place[v] < 0) continue;
    double depth = 0;
    for (const Eigen::Vector3d& point : surface[v]) {
      Matrix26 by_pose;
      Matrix23 by_point;
      Derivatives(cameras[v], point, &by_pose, &by_point);
      moves[v] += by_pose.transpose() * by_pose;
      depth += cameras[v].Depth(point);
    }
    const auto points = static_cast<double>(surface[v].size());
    moves[v] /= points;
    const PriorWeights prior = PriorOf(cameras[v], depth / points);
    const Eigen::Vector3d one = Eigen::Vector3d::Ones();
    reduced.diagonal().segment<3>(place[v]) += prior.rotation * prior.rotation * one;
    reduced.diagonal().segment<3>(place[v] + 3) += prior.center * prior.center * one;
  }
  for (int group = 0; group < tracks.groups.count; ++group) {
    const Eigen::MatrixXd held =
        HeldFreedoms(cameras, tracks.groups.ViewsOf(group), surface, place, moves, unknowns);
    reduced += kHeld * (held * held.transpose());
  }
  const Eigen::LDLT<Eigen::MatrixXd> factor(reduced);
  if (factor.info() != Eigen::Success) return deviations;
  for (size_t v = 0; v < count; ++v) {
    if (place[v] < 0) continue;
    Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(unknowns, 6);
    unit.middleRows<6>(place[v]).setIdentity();
    const Matrix6 covariance = factor.solve(unit).middleRows<6>(place[v]);
    const double variance = (moves[v] * covariance).trace();
    if (variance >= 0) deviations[v] = std::sqrt(variance);
  }
  return deviations;
}

}  // namespace burin
