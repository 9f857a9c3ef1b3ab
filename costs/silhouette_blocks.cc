#include "costs/silhouette_blocks.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace burin {
namespace {

// Of the largest eigenvalue: what is below has no gradient either.
constexpr double kNoCurvature = 1e-12;

class EdgeCost : public ceres::CostFunction {
 public:
  explicit EdgeCost(const EdgeSystem* system) : system_(system) {
    set_num_residuals(7);
    mutable_parameter_block_sizes()->assign(2, 3);
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const EdgeSystem* const system_;
};

bool EdgeCost::Evaluate(double const* const* /*parameters*/, double* residuals,
                        double** jacobians) const {
  if (!std::isfinite(system_->energy + system_->curvature.trace())) return false;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> solver(system_->curvature);
  const Eigen::Matrix<double, 6, 1>& values = solver.eigenvalues();
  const Eigen::Matrix<double, 6, 6>& vectors = solver.eigenvectors();
  double squared = 0;
  for (int i = 0; i < 6; ++i) {
    const bool flat = !(values[i] > kNoCurvature * values[5]);
    const double root = flat ? 0 : std::sqrt(values[i]);
    residuals[i] = flat ? 0 : vectors.col(i).dot(system_->gradient) / root;
    squared += residuals[i] * residuals[i];
    if (jacobians == nullptr) continue;
    for (int p = 0; p < 2; ++p) {
      if (jacobians[p] == nullptr) continue;
      for (int c = 0; c < 3; ++c) jacobians[p][3 * i + c] = root * vectors(3 * p + c, i);
    }
  }
  residuals[6] = std::sqrt(std::max(0.0, 2 * system_->energy - squared));
  for (int p = 0; jacobians != nullptr && p < 2; ++p) {
    if (jacobians[p] != nullptr) std::fill_n(jacobians[p] + 18, 3, 0.0);
  }
  return true;
}

}  // namespace

bool SilhouetteBlocks::Evaluate(int k, const TangentDirections* directions, double* energy,
                                double* gradient, double* curvature) const {
  const EdgeSystem& system = (*systems_)[k];
  *energy = system.energy;
  if (!std::isfinite(system.energy + system.curvature.trace())) return false;
  if (gradient == nullptr) return true;
  Eigen::Matrix<double, 6, 6> columns;  // d (a, b) / d unknowns
  columns.setZero();
  int count = 0;
  for (int p = 0; p < 2; ++p) {
    const auto& [plus, unknowns] = directions[p];
    for (int u = 0; u < unknowns; ++u, ++count) {
      for (int c = 0; c < 3; ++c) columns(3 * p + c, count) = plus[c * unknowns + u];
    }
  }
  for (int i = 0; i < count; ++i) {
    gradient[i] = columns.col(i).dot(system.gradient);
    if (curvature == nullptr) continue;
    const Eigen::Matrix<double, 6, 1> row = system.curvature * columns.col(i);
    for (int j = i; j < count; ++j) curvature[i * count + j] = row.dot(columns.col(j));
  }
  return true;
}

CostFunctions SilhouetteBlocks::MakeCostFunctions() const {
  CostFunctions made;
  made.parameters = parameters_;
  made.costs.reserve(size());
  for (int k = 0; k < size(); ++k) {
    made.costs.push_back(std::make_unique<EdgeCost>(&(*systems_)[k]));
  }
  return made;
}

}  // namespace burin
