// Preconditioned conjugate gradients on (A + D) x = b, all threads, sums in a fixed order.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "core/solve/symmetric_matrix.h"

namespace burin {

// Inverses of the diagonal blocks of A + D, one per block of consecutive unknowns.
class BlockJacobi {
 public:
  // `first` holds the first unknown of every block, ascending, and the number of unknowns. A block
  // that is not positive definite is replaced by its diagonal.
  void Factor(const SymmetricMatrix& matrix, const Eigen::VectorXd& damping,
              const std::vector<int>& first);
  // The same for a larger matrix: the absolute values of what is in a row outside its block are added to the diagonal.
  // It is at least A + D: their difference is positive semi-definite.
  void FactorMajorant(const SymmetricMatrix& matrix, const Eigen::VectorXd& damping,
                      const std::vector<int>& first);
  // The inverse of the block that begins at an unknown and has as many.
  Eigen::Map<const Eigen::MatrixXd> OfUnknown(int unknown, int unknowns) const;
  // z = M^-1 r
  void Apply(const Eigen::VectorXd& r, Eigen::VectorXd* z) const;

 private:
  std::vector<int> first_;
  std::vector<int64_t> start_;   // of each block's inverse
  std::vector<double> inverse_;  // dense, one after the other
};

struct ConjugateGradientOptions {
  int max_iterations = 30;
  // Stops after iteration i when i (Q_i - Q_(i-1)) / Q_i < tolerance, where
  // Q(x) = 1/2 x^T (A + D) x - b^T x: the truncated Newton test of Nash & Sofer, "Assessing a search
  // direction within a truncated-Newton method" (1990), which Ceres uses too.
  double tolerance = 0.05;
};

// Steps with cameras: along the valleys in which surface and cameras move together conjugate gradients are slow. At least
// so many iterations, and at most this tolerance.
constexpr int kJointIterations = 100;
constexpr double kJointTolerance = 0.01;

// product = (A + D) x; z = M^-1 r
using LinearMap = std::function<void(const Eigen::VectorXd& from, Eigen::VectorXd* to)>;

// x starts at zero. Returns the number of iterations.
int ConjugateGradients(const LinearMap& multiply, const LinearMap& precondition,
                       const Eigen::VectorXd& b, const ConjugateGradientOptions& options,
                       Eigen::VectorXd* x);
int ConjugateGradients(const SymmetricMatrix& matrix, const Eigen::VectorXd& damping,
                       const BlockJacobi& preconditioner, const Eigen::VectorXd& b,
                       const ConjugateGradientOptions& options, Eigen::VectorXd* x);

}  // namespace burin
