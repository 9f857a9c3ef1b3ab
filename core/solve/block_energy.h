// The energy of some of a problem's residual blocks where their parameter blocks are now. Without
// ceres::Problem::Evaluate, which makes a program of the blocks each time and runs it on one thread.
#pragma once

#include <ceres/problem.h>

#include <vector>

namespace burin {

// Sum of 1/2 rho(|r|^2) over `blocks`, added up in their order whatever the number of threads; NaN
// when a cost function fails. No evaluation callback is called: terms that have one must have been
// prepared at these parameters.
double BlockEnergy(const ceres::Problem& problem,
                   const std::vector<ceres::ResidualBlockId>& blocks);

}  // namespace burin
