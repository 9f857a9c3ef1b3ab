#include "core/cameras/intrinsics_solve.h"

#include <ceres/normal_prior.h>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/cameras/bundle.h"
#include "core/cameras/lens_reprojection.h"
#include "core/cameras/pose_uncertainty.h"
#include "core/scene/lens_points.h"
#include "core/support/median.h"

namespace burin {
namespace {

constexpr double kLeastSigmaPx = 1e-6;  // of a measurement's coordinate

}  // namespace

IntrinsicsSolve::IntrinsicsSolve(const Scene& scene, IntrinsicUnknowns unknowns)
    : shared_(CamerasSharedIn(scene, unknowns)) {
  if (shared_.empty()) return;
  camera_of_.assign(scene.views.size(), -1);
  for (size_t c = 0; c < shared_.size(); ++c) {
    for (const int v : shared_[c].views) camera_of_[v] = static_cast<int>(c);
  }
  for (const View& view : scene.views) {
    View& kept = views_.emplace_back(view);
    kept.gray = kept.mask = kept.object = kept.photographed = cv::Mat();
  }
  numbers_.assign(shared_.size(), {});
  IntrinsicNumbers unknown;
  unknown.fill(std::numeric_limits<double>::quiet_NaN());
  deviations_.assign(shared_.size(), unknown);
}

void IntrinsicsSolve::HoldUndetermined(const std::vector<int>& measured) {
  for (SharedIntrinsics& one : shared_) {
    for (const int v : one.views) one.measurements += measured[v];
    if (one.measurements < kFewestForIntrinsics) one.free.fill(false);
    if (one.AnyFree()) continue;
    for (const int v : one.views) camera_of_[v] = -1;
  }
}

Eigen::Vector2d IntrinsicsSolve::Photographed(const Measurement& measured) const {
  const View& view = views_[measured.view];
  return PhotographedAt(view.camera, view.origin.lens, measured.image_point);
}

Eigen::Vector2d IntrinsicsSolve::Offset(const CameraPose& pose, const Eigen::Vector3d& point,
                                        const Measurement& measured) const {
  const int c = camera_of_[measured.view];
  Eigen::Vector2d offset = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  const LensReprojection residual{shared_[c], Photographed(measured), 1};
  residual(pose.data(), numbers_[c].data(), point.data(), offset.data());
  return offset;
}

void IntrinsicsSolve::Add(const Measurement& measured, double scale, ceres::LossFunction* loss,
                          CameraPose* pose, Eigen::Vector3d* point, ceres::Problem* problem) {
  const int c = camera_of_[measured.view];
  auto* cost =
      new ceres::AutoDiffCostFunction<LensReprojection, 2, CameraPose::kSize, kIntrinsics, 3>(
          new LensReprojection{shared_[c], Photographed(measured), scale});
  problem->AddResidualBlock(cost, loss, pose->data(), numbers_[c].data(), point->data());
}

void IntrinsicsSolve::AddPriors(ceres::Problem* problem, ceres::ParameterBlockOrdering* ordering) {
  for (size_t c = 0; c < shared_.size(); ++c) {
    double* const numbers = numbers_[c].data();
    if (!shared_[c].AnyFree()) continue;
    const ceres::Matrix weight = ceres::Matrix::Identity(kIntrinsics, kIntrinsics) / kPriorPx;
    problem->AddResidualBlock(new ceres::NormalPrior(weight, ceres::Vector::Zero(kIntrinsics)),
                              nullptr, numbers);
    // A group orders by address: of its own, so that no allocation decides on the order.
    ordering->AddElementToGroup(numbers, 2);
    std::vector<int> held;
    for (int k = 0; k < kIntrinsics; ++k) {
      if (!shared_[c].free[k]) held.push_back(k);
    }
    if (!held.empty()) {
      manifolds_.push_back(std::make_unique<ceres::SubsetManifold>(kIntrinsics, held));
      problem->SetManifold(numbers, manifolds_.back().get());
    }
  }
}

void IntrinsicsSolve::Take(std::vector<Camera>* cameras) const {
  for (size_t v = 0; v < camera_of_.size(); ++v) {
    if (camera_of_[v] < 0) continue;
    const Camera at = shared_[camera_of_[v]].CameraAt(numbers_[camera_of_[v]]);
    Camera& camera = (*cameras)[v];
    camera.fx = at.fx;
    camera.fy = at.fy;
    camera.cx = at.cx;
    camera.cy = at.cy;
  }
}

// The inverse at the intrinsics of J^T J, measurements' rows in units of their standard deviation and priors' as they are. It
// does not depend on where the world is held.
void IntrinsicsSolve::FindDeviations(const std::vector<double*>& others, ceres::Problem* problem) {
  if (static_cast<int>(camera_of_.size()) > kMostViewsWithDeviations) return;
  ceres::Problem::EvaluateOptions options;
  std::vector<int> first(shared_.size(), -1);  // column
  int columns = 0;
  for (size_t c = 0; c < shared_.size(); ++c) {
    if (!shared_[c].AnyFree()) continue;
    first[c] = columns;
    for (const bool free : shared_[c].free) columns += free ? 1 : 0;
    options.parameter_blocks.push_back(numbers_[c].data());
  }
  if (columns == 0) return;
  for (double* block : others) {
    if (!problem->IsParameterBlockConstant(block)) options.parameter_blocks.push_back(block);
  }
  problem->GetResidualBlocks(&options.residual_blocks);
  std::vector<double> residuals;
  options.apply_loss_function = false;
  if (!problem->Evaluate(options, nullptr, &residuals, nullptr, nullptr)) return;
  ceres::CRSMatrix jacobian;
  options.apply_loss_function = true;
  if (!problem->Evaluate(options, nullptr, nullptr, nullptr, &jacobian)) return;
  std::vector<char> measured;  // by row: of a measurement, not a prior
  for (const ceres::ResidualBlockId block : options.residual_blocks) {
    const int rows = problem->GetCostFunctionForResidualBlock(block)->num_residuals();
    measured.insert(measured.end(), rows, rows == 2 ? 1 : 0);
  }
  std::vector<double> coordinates;
  for (size_t row = 0; row < measured.size(); ++row) {
    if (measured[row] != 0) coordinates.push_back(std::abs(residuals[row]));
  }
  const double sigma = std::max(kLeastSigmaPx, kSigmaOfMedian * Median(coordinates));
  for (size_t row = 0; row < measured.size(); ++row) {
    for (int k = jacobian.rows[row]; k < jacobian.rows[row + 1] && measured[row] != 0; ++k) {
      jacobian.values[k] /= sigma;
    }
  }
  const Eigen::Map<const Eigen::SparseMatrix<double, Eigen::RowMajor>> j(
      jacobian.num_rows, jacobian.num_cols, static_cast<int>(jacobian.values.size()),
      jacobian.rows.data(), jacobian.cols.data(), jacobian.values.data());
  const Eigen::SparseMatrix<double> columns_of_j = j;
  const Eigen::SparseMatrix<double> curvature = columns_of_j.transpose() * columns_of_j;
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(curvature);
  if (factor.info() != Eigen::Success) return;
  for (size_t c = 0; c < shared_.size(); ++c) {
    if (first[c] < 0) continue;
    int column = first[c];
    for (int k = 0; k < kIntrinsics; ++k) {
      deviations_[c][k] = 0;
      if (!shared_[c].free[k]) continue;
      const Eigen::VectorXd covariance =
          factor.solve(Eigen::VectorXd::Unit(jacobian.num_cols, column));
      deviations_[c][k] = std::sqrt(covariance[column]);
      ++column;
    }
  }
}

void IntrinsicsSolve::Report(std::vector<Lens>* lenses,
                             std::vector<SharedIntrinsics>* shared) const {
  *shared = shared_;
  lenses->clear();
  for (const View& view : views_) lenses->push_back(view.origin.lens);
  for (size_t c = 0; c < shared_.size(); ++c) {
    (*shared)[c].deviation_px = deviations_[c];
    if (!shared_[c].AnyFree()) continue;
    for (const int v : shared_[c].views) (*lenses)[v] = shared_[c].LensAt(numbers_[c]);
  }
}

}  // namespace burin
