// The minimisers burin can use on a round's ceres::Problem, by name. They all see the same problem
// and differ only in the function in the table of solver_strategy.cc; adding one is one function
// and one row.
#pragma once

#include <ceres/problem.h>

#include <Eigen/Core>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "core/energy_term.h"
#include "core/options.h"

namespace burin {

struct SolverOptions {
  std::string type = "auto";
  int max_iterations = 12;           // per round
  double function_tolerance = 3e-4;  // stop when |dE| < tolerance * E
  int cholesky_max_unknowns = 60000;
  int cg_max_iterations = 30;  // of CGNR, per LM step
  double cg_tolerance = 0.05;  // of CGNR: eta of the truncated Newton step
  double initial_trust_radius = 1e4;
  double gradient_step_px = 0.25;  // gradient_descent
  double umbrella_step = 0.1;      // gradient_descent
  void Describe(OptionSet* set);
};

// One accepted or rejected iteration.
struct IterationRecord {
  int iteration = 0;
  double energy = 0;        // of all terms, whatever the strategy minimises
  double gradient_max = 0;  // largest component, per pixel footprint
  double step_norm = 0;     // pixel footprints, Euclidean norm over all vertices
  bool accepted = true;
  int linear_iterations = 0;
  double seconds = 0;  // since the start of the solve
};

// What a strategy gets to work on. Positions are in the normalised world, whose unit is the median
// pixel footprint; manifolds and constant blocks are already set.
struct SolveTask {
  ceres::Problem* problem = nullptr;
  std::vector<Eigen::Vector3d>* vertices = nullptr;
  const RoundContext* context = nullptr;
  // Residual blocks by term, in the order in which the terms were given.
  std::vector<std::pair<std::string, std::vector<ceres::ResidualBlockId>>> term_blocks;
  // Called after every iteration; false stops the solve.
  std::function<bool(const IterationRecord&)> on_iteration;
  // The vertices must hold the last accepted point whenever on_iteration is called. Otherwise they
  // may hold any point tried.
  bool follow_vertices = false;
};

struct SolveSummary {
  bool usable = false;  // the vertices hold a point at least as good as the start
  double initial_energy = 0;
  double final_energy = 0;
  int iterations = 0;
  int unknowns = 0;
  double linear_solver_seconds = 0;
  std::string strategy;
  std::string termination;  // one line
};

struct Strategy {
  std::string name;
  std::string description;  // one line
  std::function<SolveSummary(const SolveTask&, const SolverOptions&)> solve;
};

const std::vector<Strategy>& Strategies();

// The strategy called `name`, null when there is none; "auto" gives lm_cholesky up to
// options.cholesky_max_unknowns unknowns, else lm_cgnr.
const Strategy* FindStrategy(const std::string& name, int unknowns, const SolverOptions& options);

}  // namespace burin
