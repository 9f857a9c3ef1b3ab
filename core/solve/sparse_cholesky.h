// P (A + D) P^T = L L^T of a SymmetricMatrix by CHOLMOD (SuiteSparse), and the two half solves that
// change variables: y = L^T P x turns 1/2 x^T (A + D) x into 1/2 |y|^2.
#pragma once

#include <Eigen/Core>
#include <memory>

#include "core/solve/symmetric_matrix.h"

namespace burin {

class SparseCholesky {
 public:
  SparseCholesky();
  ~SparseCholesky();
  SparseCholesky(const SparseCholesky&) = delete;
  SparseCholesky& operator=(const SparseCholesky&) = delete;

  // Factors A + D, D diagonal. The ordering is found in the first call; later calls must have the
  // same pattern. False when the matrix is not positive definite or memory is short.
  bool Factor(const SymmetricMatrix& matrix, const Eigen::VectorXd& damping);
  // x = L^-1 P b
  void ApplyInverseLower(const Eigen::VectorXd& b, Eigen::VectorXd* x);
  // x = P^T L^-T b
  void ApplyInverseUpper(const Eigen::VectorXd& b, Eigen::VectorXd* x);
  // Numbers in L.
  double fill() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace burin
