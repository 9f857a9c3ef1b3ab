#include "core/solve/solver_strategy.h"

#include <glog/logging.h>

#include "core/solve/strategies.h"

namespace burin {

void SolverOptions::Describe(OptionSet* set) {
  std::vector<std::string> names = {"auto"};
  for (const Strategy& strategy : Strategies()) names.push_back(strategy.name);
  set->Add("solver.type", &type,
           "Minimiser; auto = lm_pcg, or lm_cholesky up to solver.cholesky_max_unknowns", names);
  set->Add("solver.max_iterations", &max_iterations, "Iterations a round at most", 0, 100000);
  set->Add("solver.function_tolerance", &function_tolerance,
           "A round ends when |dE| < function_tolerance * E", 0, 1);
  set->Add("solver.min_step_px", &min_step_px,
           "A round ends when the RMS displacement of a step is below this, pixels of the level "
           "(lm_*, dogleg); 0 = off",
           0, 1000);
  set->Add("solver.cholesky_max_unknowns", &cholesky_max_unknowns,
           "auto takes lm_cholesky up to this many unknowns", 0, 1e9);
  set->Add("solver.cg_max_iterations", &cg_max_iterations,
           "Conjugate-gradient iterations a step at most (lm_cgnr, lm_pcg)", 1, 100000);
  set->Add("solver.cg_tolerance", &cg_tolerance,
           "Relative accuracy of the truncated Newton step (lm_cgnr, lm_pcg)", 1e-12, 1);
  set->Add("solver.initial_trust_radius", &initial_trust_radius,
           "Initial trust-region radius in Ceres' scaling (lm_*, dogleg, lbfgs_h)", 1e-12, 1e32);
  set->Add("solver.camera_damping", &camera_damping,
           "Damping of cameras that move, a share of their median curvature (all but lbfgs_*)", 0,
           1e6);
  set->Add("solver.sobolev_length", &sobolev_length,
           "Length over which lbfgs_sobolev smooths gradients, edges of the mesh", 0, 1000);
  set->Add("solver.gradient_step_px", &gradient_step_px,
           "99th percentile of the first move, pixel footprints (gradient_descent)", 1e-9, 1000);
  set->Add("solver.umbrella_step", &umbrella_step,
           "Share of the way to the neighbours' mean a step (gradient_descent)", 0, 1);
}

namespace {

std::vector<Strategy>& Table() {
  static auto* table = new std::vector<Strategy>{
#define BURIN_STRATEGY(name, function, max_unknowns, description) \
  {name, description, max_unknowns, function, /*moves_cameras=*/true},
#include "core/solve/strategies.inc"
#undef BURIN_STRATEGY
  };
  return *table;
}

}  // namespace

const std::vector<Strategy>& Strategies() { return Table(); }

void AddStrategy(const Strategy& strategy) {
  CHECK(strategy.solve != nullptr);
  CHECK(FindStrategy(strategy.name, 0, SolverOptions()) == nullptr) << strategy.name << ": exists";
  Table().push_back(strategy);
}

const Strategy* FindStrategy(const std::string& name, int unknowns, const SolverOptions& options) {
  const std::string wanted =
      name != "auto" ? name
                     : (unknowns <= options.cholesky_max_unknowns ? "lm_cholesky" : "lm_pcg");
  for (const Strategy& strategy : Strategies()) {
    if (strategy.name == wanted) return &strategy;
  }
  return nullptr;
}

}  // namespace burin
