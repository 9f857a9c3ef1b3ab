// The minimisers burin can use on a round's energy, by name. They all see the same energy, those of Ceres as a
// ceres::Problem (core/solve/ceres_problem.h);
// adding one is a file core/solve/strategy_NAME.cc and a row of core/solve/strategies.inc.
#pragma once

#include <ceres/evaluation_callback.h>

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "core/solve/energy_term.h"
#include "core/support/options.h"

namespace burin {

struct SolverOptions {
  std::string type = "auto";
  int max_iterations = 12;  // per round
  // A round ends when |E(x) - E(x + s)| <= function_tolerance E(x).
  double function_tolerance = 3e-4;
  // lm_pcg: a round ends before evaluating a step s whose predicted
  //   sqrt( sum_v |s_v|^2 / (moving vertices) ) / 2^level < min_step_px,
  // the RMS displacement in pixels of the level. lm_cholesky, lm_cgnr and dogleg end after a taken
  // step that is as short. 0 = never.
  double min_step_px = 0;
  int cholesky_max_unknowns = 0;
  int cg_max_iterations = 30;  // of CGNR and PCG, per LM step
  double cg_tolerance = 0.05;  // of CGNR and PCG: eta of the truncated Newton step
  double initial_trust_radius = 1e4;
  // Cameras that move: what is added to the diagonal of each of their unknowns, as a share of the median over the
  // cameras; in steps of lm_pcg, and in the units (core/solve/camera_units.h) of Ceres' minimisers and
  // gradient_descent. Holds views along motions that the photographs hardly tell from each other.
  double camera_damping = 0.003;
  double sobolev_length = 4;       // lbfgs_sobolev, edges
  double gradient_step_px = 0.25;  // gradient_descent
  double umbrella_step = 0.1;      // gradient_descent
  void Describe(OptionSet* set);
};

// One accepted or rejected iteration.
struct IterationRecord {
  int iteration = 0;
  double energy = 0;        // of all terms, whatever the strategy minimises
  double gradient_max = 0;  // largest component, per pixel footprint
  // Pixel footprints, Euclidean norm over all vertices, and cameras that move in units as stiff as vertices.
  double step_norm = 0;
  bool accepted = true;
  int linear_iterations = 0;
  double seconds = 0;  // since the start of the solve
};

// What a strategy gets to work on. Positions are in the normalised world, whose unit is the median
// pixel footprint; manifolds and constant blocks are already set.
struct SolveTask {
  const RoundEnergy* energy = nullptr;
  ceres::EvaluationCallback* evaluation_callback = nullptr;  // of the terms
  std::vector<Eigen::Vector3d>* vertices = nullptr;
  const RoundContext* context = nullptr;
  double pixel = 1;  // of the level, 2^level in the unit of the positions
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
  int max_unknowns = 0;     // 0 = no limit
  // Everything of the summary but `strategy`, which Refine fills in.
  SolveSummary (*solve)(const SolveTask& task, const SolverOptions& options);
  bool moves_cameras = false;  // takes rounds with RoundParameters::cameras; all of burin's own do
};

const std::vector<Strategy>& Strategies();

// For programs that bring a strategy of their own: from then on it is a choice of solver.type. Before any
// options are described, on one thread. CHECKs that there is none of its name.
void AddStrategy(const Strategy& strategy);

// The strategy called `name`, null when there is none; "auto" gives lm_cholesky up to
// options.cholesky_max_unknowns unknowns, else lm_pcg.
const Strategy* FindStrategy(const std::string& name, int unknowns, const SolverOptions& options);

}  // namespace burin
