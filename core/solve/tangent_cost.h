// A cost function that knows its energy, gradient and curvature without a detour over residuals.
//
// Ceres' minimisers need residuals r and their Jacobian J. burin's own normal equations
// (core/solve/normal_equations.h) need what follows from them: 1/2 |r|^2, J^T r and J^T J. A term that makes r and
// J by factoring a curvature matrix hands over the matrix instead.
#pragma once

#include <ceres/cost_function.h>
#include <ceres/problem.h>

#include <vector>

namespace burin {

// Of one parameter block: how it moves with the unknowns of the solve. For a constant block `columns` is 0.
struct TangentDirections {
  const double* plus;  // d block / d unknowns, size x columns, row-major
  int columns;
};

class TangentCost : public ceres::CostFunction {
 public:
  // 1/2 |r|^2 of Evaluate()'s residuals at `parameters`, and where they are not null J^T r (m entries) and the upper
  // triangle of J^T J (m x m, row-major; what is below the diagonal is left as it is), to rounding. m is the sum of
  // all columns. False when the cost has no finite value there.
  virtual bool EvaluateTangent(double const* const* parameters, const TangentDirections* directions,
                               double* cost, double* gradient, double* curvature) const = 0;

  // Residuals will be asked for on one thread: a term may prepare those of all its costs on all threads then, when it is
  // told of a new point. Off until said.
  virtual void ExpectResiduals(bool on) { (void)on; }
};

// ExpectResiduals() of all such costs of a problem, for as long as this lives.
class ResidualsExpected {
 public:
  explicit ResidualsExpected(ceres::Problem* problem);
  ~ResidualsExpected();
  ResidualsExpected(const ResidualsExpected&) = delete;
  ResidualsExpected& operator=(const ResidualsExpected&) = delete;

 private:
  std::vector<TangentCost*> costs_;
};

}  // namespace burin
