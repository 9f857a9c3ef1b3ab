// A matrix that knows only its products, written out: for tests of small systems.
#pragma once

#include <Eigen/Core>

#include "core/solve/normal_equations.h"

namespace burin::test {

inline Eigen::MatrixXd Dense(const NormalEquations& equations) {
  const int size = equations.unknowns();
  Eigen::MatrixXd dense(size, size);
  Eigen::VectorXd column;
  for (int u = 0; u < size; ++u) {
    equations.Multiply(Eigen::VectorXd::Unit(size, u), Eigen::VectorXd(), &column);
    dense.col(u) = column;
  }
  return dense;
}

}  // namespace burin::test
