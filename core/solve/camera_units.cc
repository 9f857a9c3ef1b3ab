#include "core/solve/camera_units.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <cstdint>
#include <utility>

#include "core/solve/camera_border.h"

namespace burin {
namespace {

constexpr double kLeastShare =
    1e-9;  // of a block's largest entry: what a motion without curvature has

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Plus(x, d) of another manifold for U d, U square.
class InUnits : public ceres::Manifold {
 public:
  InUnits(const ceres::Manifold* manifold, Eigen::MatrixXd units)
      : manifold_(manifold), units_(std::move(units)), inverse_(units_.inverse()) {}
  int AmbientSize() const override { return manifold_->AmbientSize(); }
  int TangentSize() const override { return manifold_->TangentSize(); }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    const Eigen::VectorXd step = units_ * Eigen::Map<const Eigen::VectorXd>(delta, TangentSize());
    return manifold_->Plus(x, step.data(), x_plus_delta);
  }
  bool PlusJacobian(const double* x, double* jacobian) const override {
    RowMajor own(AmbientSize(), TangentSize());
    if (!manifold_->PlusJacobian(x, own.data())) return false;
    Eigen::Map<RowMajor>(jacobian, AmbientSize(), TangentSize()) = own * units_;
    return true;
  }
  bool Minus(const double* y, const double* x, double* y_minus_x) const override {
    Eigen::VectorXd step(TangentSize());
    if (!manifold_->Minus(y, x, step.data())) return false;
    Eigen::Map<Eigen::VectorXd>(y_minus_x, TangentSize()) = inverse_ * step;
    return true;
  }
  bool MinusJacobian(const double* x, double* jacobian) const override {
    RowMajor own(TangentSize(), AmbientSize());
    if (!manifold_->MinusJacobian(x, own.data())) return false;
    Eigen::Map<RowMajor>(jacobian, TangentSize(), AmbientSize()) = inverse_ * own;
    return true;
  }

 private:
  const ceres::Manifold* manifold_;
  const Eigen::MatrixXd units_;
  const Eigen::MatrixXd inverse_;
};

// How a parameter moves with its unknowns; nothing for a constant one.
RowMajor PlusOf(const RoundEnergy& energy, int parameter) {
  if (energy.IsConstant(parameter)) return {};
  const int size = energy.Size(parameter);
  const ceres::Manifold* manifold = energy.ManifoldOf(parameter);
  if (manifold == nullptr) return RowMajor::Identity(size, size);
  RowMajor plus(size, manifold->TangentSize());
  if (!manifold->PlusJacobian(energy.Values(parameter), plus.data())) plus.setZero();
  return plus;
}

// Diagonal blocks of cameras, and the sum of the diagonal of all other unknowns.
struct Curvature {
  std::vector<Eigen::MatrixXd> of_camera;
  double others = 0;
  int64_t unknowns = 0;  // of these
};

Curvature CurvatureOf(const RoundEnergy& energy) {
  std::vector<RowMajor> plus(energy.ParameterCount());
  Curvature sums;
  sums.of_camera.resize(energy.CameraCount());
  for (const int p : energy.Used()) {
    plus[p] = PlusOf(energy, p);
    if (energy.IsCamera(p)) {
      sums.of_camera[p - energy.FirstCamera()].setZero(plus[p].cols(), plus[p].cols());
    } else {
      sums.unknowns += plus[p].cols();
    }
  }
  std::vector<TangentDirections> directions;
  std::vector<double> gradient;
  std::vector<double> curvature;
  for (const RoundEnergy::Part& part : energy.parts()) {
    part.blocks->Prepare(/*curvature=*/true);
    const Adjacency& parameters = part.blocks->parameters();
    for (int k = 0; k < part.blocks->size(); ++k) {
      directions.clear();
      int size = 0;
      for (const int* p = parameters.Begin(k); p != parameters.End(k); ++p) {
        directions.push_back({plus[*p].data(), static_cast<int>(plus[*p].cols())});
        size += directions.back().columns;
      }
      gradient.resize(size);
      curvature.assign(static_cast<size_t>(size) * size, 0.0);
      double value = 0;
      if (!part.blocks->Evaluate(k, directions.data(), &value, gradient.data(), curvature.data())) {
        continue;
      }
      const Eigen::Map<const RowMajor> whole(curvature.data(), size, size);
      int first = 0;
      for (const int* p = parameters.Begin(k); p != parameters.End(k); ++p) {
        const auto own = whole.block(first, first, plus[*p].cols(), plus[*p].cols());
        if (energy.IsCamera(*p)) {
          sums.of_camera[*p - energy.FirstCamera()] += own.selfadjointView<Eigen::Upper>();
        } else {
          sums.others += own.trace();
        }
        first += static_cast<int>(plus[*p].cols());
      }
    }
  }
  return sums;
}

}  // namespace

CameraUnits::CameraUnits(const RoundEnergy& energy, ceres::EvaluationCallback* callback,
                         double damping)
    : manifolds_(energy.CameraCount()) {
  if (callback != nullptr) callback->PrepareForEvaluation(true, true);
  const Curvature curvature = CurvatureOf(energy);
  if (curvature.others > 0) {
    curvature_ = curvature.others / static_cast<double>(curvature.unknowns);
  }
  std::vector<Eigen::VectorXd> diagonals;
  for (const Eigen::MatrixXd& own : curvature.of_camera) diagonals.emplace_back(own.diagonal());
  const std::vector<Eigen::VectorXd> medians = MedianDiagonals(diagonals);
  for (int camera = 0; camera < energy.CameraCount(); ++camera) {
    Eigen::MatrixXd own = curvature.of_camera[camera];
    const ceres::Manifold* manifold = energy.ManifoldOf(energy.FirstCamera() + camera);
    if (own.size() == 0 || manifold == nullptr) continue;
    own.diagonal() += damping * medians[camera];
    own.diagonal().array() += kLeastShare * own.diagonal().maxCoeff() + kLeastShare;
    const Eigen::LLT<Eigen::MatrixXd> factor(own);
    const Eigen::MatrixXd root = factor.matrixU();  // L^T
    const Eigen::MatrixXd units =
        std::sqrt(curvature_) * root.triangularView<Eigen::Upper>().solve(
                                    Eigen::MatrixXd::Identity(own.rows(), own.cols()));
    manifolds_[camera] = std::make_unique<InUnits>(manifold, units);
  }
}

}  // namespace burin
