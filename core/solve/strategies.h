// What strategy files share: the declarations of their functions, made from the table's rows, and
// the order of unknowns.
#pragma once

#include <vector>

#include "core/solve/solver_strategy.h"

namespace burin {

#define BURIN_STRATEGY(name, function, max_unknowns, description) \
  SolveSummary function(const SolveTask& task, const SolverOptions& options);
#include "core/solve/strategies.inc"
#undef BURIN_STRATEGY

}  // namespace burin
