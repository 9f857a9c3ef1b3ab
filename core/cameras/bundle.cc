#include "core/cameras/bundle.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <memory>

#include "core/cameras/intrinsics_solve.h"
#include "core/scene/camera_pose.h"
#include "core/support/median.h"

namespace burin {
namespace {

constexpr double kMedians = 1.5;
constexpr int kSolves = 4;
constexpr int kTriangulationSteps = 10;
constexpr int kDenseViews = 150;  // above it the reduced camera matrix is kept sparse

// (pi(X) - x) / s of a pose and a point.
struct Reprojection {
  const Camera& camera;
  Eigen::Vector2d measured;
  double scale;
  template <typename T>
  bool operator()(const T* pose, const T* point, T* residuals) const {
    const Eigen::Map<const Eigen::Quaternion<T>> rotation(pose);
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> center(pose + 4);
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> world(point);
    const Eigen::Matrix<T, 3, 1> seen = rotation * (world - center);
    residuals[0] = (camera.fx * seen.x() / seen.z() + camera.cx - measured.x()) / scale;
    residuals[1] = (camera.fy * seen.y() / seen.z() + camera.cy - measured.y()) / scale;
    return true;
  }
};

// W (pose - start).
struct PosePrior {
  CameraPose start;
  PriorWeights weights;
  template <typename T>
  bool operator()(const T* pose, T* residuals) const {
    const Eigen::Map<const Eigen::Quaternion<T>> now(pose);
    const Eigen::Map<const Eigen::Quaterniond> was(start.rotation);
    const Eigen::Quaternion<T> turned = now * was.conjugate().cast<T>();
    for (int k = 0; k < 3; ++k) {
      residuals[k] = 2.0 * weights.rotation * turned.coeffs()[k];
      residuals[3 + k] = weights.center * (pose[4 + k] - start.center[k]);
    }
    return true;
  }
};

// Sparse tracks are what the cameras given were made of: they do not judge.
bool IsKeptOut(const MeshTracks& found, size_t track) {
  return track < found.windows && track % 5 == 4;
}

double Cauchy(double squared, double scale) {
  return 0.5 * scale * scale * std::log1p(squared / (scale * scale));
}

struct Residual {
  Eigen::Vector2d value;  // pixels of the image searched
  Eigen::Matrix<double, 2, 3> by_point;
};

bool ResidualOf(const Camera& camera, const Measurement& measured, double pixel,
                const Eigen::Vector3d& point, Residual* residual) {
  const Eigen::Vector3d seen = camera.rotation * point + camera.translation;
  if (!(seen.z() > 0)) return false;
  residual->value = (camera.Project(point) - measured.image_point) / pixel;
  residual->by_point = camera.ProjectByPoint(seen) / pixel;
  return residual->value.allFinite();
}

// Nearest to the rays of the measurements.
Eigen::Vector3d NearestToRays(const std::vector<Camera>& cameras, const Tracks::Range& track) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Measurement& measured : track) {
    const Camera& camera = cameras[measured.view];
    const Eigen::Vector3d ray =
        camera.Ray(measured.image_point.x(), measured.image_point.y()).normalized();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray * ray.transpose();
    sum += across;
    right += across * camera.Center();
  }
  return sum.ldlt().solve(right);
}

// Mean loss of a track's measurements where the cameras put its point; negative where they put none.
double LossOf(const MeshTracks& found, const std::vector<Camera>& cameras, size_t track) {
  Eigen::Vector3d point;
  const Tracks::Range range = found.tracks.Of(track);
  if (!Triangulate(cameras, range, found.pixel, kFinestLossPx, &point)) return -1;
  double sum = 0;
  for (const Measurement& measured : range) {
    Residual residual;
    if (!ResidualOf(cameras[measured.view], measured, found.pixel[measured.view], point,
                    &residual)) {
      return -1;
    }
    sum += Cauchy(residual.value.squaredNorm(), kFinestLossPx);
  }
  return sum / static_cast<double>(range.size());
}

class BundleProblem {
 public:
  BundleProblem(const Scene& scene, const MeshTracks& found, IntrinsicUnknowns unknowns)
      : found_(found), intrinsics_(scene, unknowns) {
    for (const View& view : scene.views) {
      cameras_.push_back(view.camera);
      poses_.push_back(PoseOf(view.camera));
    }
    start_ = cameras_;
  }

  Bundle Solve() {
    Bundle bundle;
    bundle.measured.assign(cameras_.size(), 0);
    MakePoints();
    for (const size_t p : used_) {
      for (const Measurement& measured : found_.tracks.Of(p)) {
        ++bundle.measured[measured.view];
        ++bundle.measurements;
      }
    }
    bundle.tracks = static_cast<int>(used_.size());
    intrinsics_.HoldUndetermined(bundle.measured);
    double loss = LossScale(&bundle.median_before);
    bundle.median_after = bundle.median_before;
    if (!used_.empty()) {
      for (int k = 0; k < kSolves; ++k) {
        SolveOnce(loss, bundle.measured);
        const double next = LossScale(&bundle.median_after);
        if (loss <= kFinestLossPx) break;
        loss = k + 2 == kSolves ? kFinestLossPx : next;
      }
    }
    bundle.sigma = sigma_;
    bundle.sparse_scale = found_.sparse_scale;
    bundle.cameras = cameras_;
    intrinsics_.Report(&bundle.lenses, &bundle.shared);
    return bundle;
  }

 private:
  // The points of the tracks that are used.
  void MakePoints() {
    points_ = found_.points;
    for (size_t p = 0; p < found_.tracks.PointCount(); ++p) {
      if (IsKeptOut(found_, p)) continue;
      const Eigen::Vector3d nearest = NearestToRays(cameras_, found_.tracks.Of(p));
      bool before_all = nearest.allFinite();
      for (const Measurement& measured : found_.tracks.Of(p)) {
        before_all = before_all && cameras_[measured.view].Depth(nearest) > 0;
      }
      if (before_all) points_[p] = nearest;
      used_.push_back(p);
    }
  }

  // From the residuals as they are, windows and sparse points each by their own.
  double LossScale(double* median_px) {
    std::vector<double> distances[2];
    std::vector<double> pixels;
    std::vector<double> coordinates;
    for (const size_t p : used_) {
      const bool is_sparse = p >= found_.windows;
      for (const Measurement& measured : found_.tracks.Of(p)) {
        Residual residual;
        const double pixel = found_.pixel[measured.view];
        if (intrinsics_.AreFreeIn(measured.view)) {
          residual.value = intrinsics_.Offset(poses_[measured.view], points_[p], measured) / pixel;
        } else if (!ResidualOf(cameras_[measured.view], measured, pixel, points_[p], &residual)) {
          continue;
        }
        distances[is_sparse ? 1 : 0].push_back(residual.value.norm());
        if (is_sparse) continue;
        pixels.push_back(distances[0].back() * pixel);
        coordinates.push_back(std::abs(residual.value.x()));
        coordinates.push_back(std::abs(residual.value.y()));
      }
    }
    if (distances[0].empty()) return kFinestLossPx;
    *median_px = Median(pixels);
    const auto known = static_cast<double>(coordinates.size() + 2 * distances[1].size());
    const double free = std::max(1.0, known - Unknowns());
    sigma_ = kSigmaOfMedian * Median(coordinates) * std::sqrt(known / free);
    const double median = Median(distances[0]);
    if (!distances[1].empty() && median > 0) {
      found_.sparse_scale = std::max(1.0, Median(distances[1]) / median);
    }
    return std::max(kFinestLossPx, kMedians * median);
  }

  // Of points and views, less the freedoms of every group's world.
  double Unknowns() const {
    const auto& of_view = found_.groups.of_view;
    const auto held = std::count(of_view.begin(), of_view.end(), -1);
    return 3 * static_cast<double>(used_.size()) + 6 * static_cast<double>(of_view.size() - held) -
           7.0 * found_.groups.count;
  }

  void SolveOnce(double loss, const std::vector<int>& measured_in) {
    ceres::Problem::Options ownership;
    ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ownership.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::CauchyLoss cauchy(loss);
    ceres::ProductManifold<ceres::EigenQuaternionManifold, ceres::EuclideanManifold<3>> manifold;
    ceres::Problem problem(ownership);
    auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    std::vector<double> depth(cameras_.size(), 0);
    for (const size_t p : used_) {
      for (const Measurement& measured : found_.tracks.Of(p)) {
        const int v = measured.view;
        if (intrinsics_.AreFreeIn(v)) {
          intrinsics_.Add(measured, found_.ScaleOf(p, v), &cauchy, &poses_[v], &points_[p],
                          &problem);
        } else {
          auto* cost = new ceres::AutoDiffCostFunction<Reprojection, 2, 7, 3>(
              new Reprojection{start_[v], measured.image_point, found_.ScaleOf(p, v)});
          problem.AddResidualBlock(cost, &cauchy, poses_[v].data(), points_[p].data());
        }
        depth[v] += cameras_[v].Depth(points_[p]);
      }
      ordering->AddElementToGroup(points_[p].data(), 0);
    }
    for (size_t v = 0; v < cameras_.size(); ++v) {
      if (measured_in[v] == 0) continue;
      auto* prior = new ceres::AutoDiffCostFunction<PosePrior, 6, 7>(
          new PosePrior{PoseOf(start_[v]), PriorOf(start_[v], depth[v] / measured_in[v])});
      problem.AddResidualBlock(prior, nullptr, poses_[v].data());
      problem.SetManifold(poses_[v].data(), &manifold);
      ordering->AddElementToGroup(poses_[v].data(), 1);
    }
    intrinsics_.AddPriors(&problem, ordering.get());
    ceres::Solver::Options options;
    options.linear_solver_type =
        static_cast<int>(cameras_.size()) > kDenseViews ? ceres::SPARSE_SCHUR : ceres::DENSE_SCHUR;
    options.linear_solver_ordering = ordering;
    options.num_threads = 1;
    options.max_num_iterations = 50;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    if (!summary.IsSolutionUsable()) return;
    for (size_t v = 0; v < cameras_.size(); ++v) SetPose(poses_[v], &cameras_[v]);
    intrinsics_.Take(&cameras_);
    if (loss > kFinestLossPx) return;  // not the last
    std::vector<double*> blocks;
    for (size_t v = 0; v < cameras_.size(); ++v) {
      if (measured_in[v] > 0) blocks.push_back(poses_[v].data());
    }
    for (const size_t p : used_) blocks.push_back(points_[p].data());
    intrinsics_.FindDeviations(blocks, &problem);
  }

  MeshTracks found_;
  std::vector<Camera> start_;
  std::vector<Camera> cameras_;  // now
  std::vector<CameraPose> poses_;
  std::vector<Eigen::Vector3d> points_;
  std::vector<size_t> used_;
  IntrinsicsSolve intrinsics_;
  double sigma_ = 0;
};

}  // namespace

bool Triangulate(const std::vector<Camera>& cameras, const Tracks::Range& track,
                 const std::vector<double>& pixel, double loss_px, Eigen::Vector3d* point) {
  Eigen::Vector3d at = NearestToRays(cameras, track);
  for (int step = 0; step < kTriangulationSteps; ++step) {
    if (!at.allFinite()) return false;
    Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    for (const Measurement& measured : track) {
      Residual residual;
      if (!ResidualOf(cameras[measured.view], measured, pixel[measured.view], at, &residual)) {
        return false;
      }
      const double weight = 1 / (1 + residual.value.squaredNorm() / (loss_px * loss_px));
      hessian += weight * residual.by_point.transpose() * residual.by_point;
      gradient += weight * residual.by_point.transpose() * residual.value;
    }
    at -= hessian.ldlt().solve(gradient);
  }
  for (const Measurement& measured : track) {
    if (!(cameras[measured.view].Depth(at) > 0)) return false;
  }
  *point = at;
  return at.allFinite();
}

PriorWeights PriorOf(const Camera& camera, double depth) {
  const double focal = std::sqrt(camera.fx * camera.fy);
  return {focal / kPriorPx, focal / std::max(1e-300, std::abs(depth)) / kPriorPx};
}

TrackAgreement CompareKeptOut(int group, const MeshTracks& tracks_before,
                              const std::vector<Camera>& before, const MeshTracks& tracks_after,
                              const std::vector<Camera>& after) {
  TrackAgreement agreement;
  std::vector<double> changes;
  for (size_t p = 0; p < tracks_before.tracks.PointCount(); ++p) {
    const int first = tracks_before.tracks.Of(p).first->view;
    if (!IsKeptOut(tracks_before, p) || tracks_before.groups.of_view[first] != group) continue;
    const double loss_before = LossOf(tracks_before, before, p);
    const double loss_after = LossOf(tracks_after, after, p);
    if (loss_before < 0 || loss_after < 0) continue;
    agreement.before += loss_before;
    agreement.after += loss_after;
    changes.push_back(loss_after - loss_before);
  }
  agreement.tracks = static_cast<int>(changes.size());
  if (agreement.tracks == 0) return agreement;
  agreement.before /= agreement.tracks;
  agreement.after /= agreement.tracks;
  double squares = 0;
  for (const double change : changes) {
    const double off = change - (agreement.after - agreement.before);
    squares += off * off;
  }
  agreement.standard_error = std::sqrt(squares) / agreement.tracks;
  return agreement;
}

Bundle AdjustBundle(const Scene& scene, const MeshTracks& tracks, IntrinsicUnknowns unknowns) {
  return BundleProblem(scene, tracks, unknowns).Solve();
}

}  // namespace burin
