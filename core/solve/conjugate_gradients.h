// Preconditioned conjugate gradients on (A + D) x = b, all threads, sums in a fixed order.
#pragma once

#include <Eigen/Core>
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

// x starts at zero. Returns the number of iterations.
int ConjugateGradients(const SymmetricMatrix& matrix, const Eigen::VectorXd& damping,
                       const BlockJacobi& preconditioner, const Eigen::VectorXd& b,
                       const ConjugateGradientOptions& options, Eigen::VectorXd* x);

}  // namespace burin
