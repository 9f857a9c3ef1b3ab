// A round that is ready to be solved, as one energy over vertex positions: what the loop of
// core/refine/refinement.h hands to a strategy, and to whoever compares strategies from the same start.
#pragma once

#include <ceres/evaluation_callback.h>

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/solve/energy_term.h"
#include "core/solve/motion.h"
#include "core/solve/solver_strategy.h"

namespace burin {

// What a strategy made of a frozen round.
struct RoundTrial {
  SolveSummary solve;
  std::vector<Eigen::Vector3d> vertices;  // normalised world; the start when not usable
  std::vector<CameraPose> cameras;        // likewise; empty where cameras do not move
  double camera_px = 0;                   // by FrozenRound::solve, where they do: see Progress
  nlohmann::json energy_initial;          // by term
  nlohmann::json energy_final;
  int64_t windows_initial = 0;  // of which the energies are sums
  int64_t windows_final = 0;
  int64_t evaluations = 0;  // by the strategy, that of the start included
  double seconds = 0;       // of the strategy, without the time spent in `on_progress`
};

// A round that is ready to be solved: mesh, visibility, masks and pairs are frozen. It can be
// solved any number of times; each time starts from the same positions with nothing evaluated yet.
struct FrozenRound {
  int level = 0;
  int round = 0;
  int unknowns = 0;
  int cameras = 0;  // that are among these
  const RoundContext* context = nullptr;
  // The mesh with these vertices (normalised world, in the round's order), in the world and in the
  // caller's order, as Refine would return it.
  std::function<TriangleMesh(const std::vector<Eigen::Vector3d>&)> world_mesh;

  // One iteration of a trial. `record.seconds` is the time of the strategy alone.
  struct Progress {
    IterationRecord record;
    int64_t evaluations = 0;                                 // so far, that of the start included
    const std::vector<Eigen::Vector3d>* vertices = nullptr;  // accepted so far, normalised world
    // By how many pixels of the level the surface's image moved with the cameras: RMS over the views
    // (core/refine/camera_rounds.h: TakeCameras).
    double camera_px = 0;
  };
  using OnProgress = std::function<bool(const Progress&)>;
  // Solves the round with the strategy of that name ("auto" included). `on_progress` may be empty;
  // false stops the trial. Its first call is for the start, its last with an accepted point for what
  // the trial returns: where that is not the strategy's last iteration (Ceres' line searches end
  // without reporting theirs, gradient_descent returns its best), there is one more call for it.
  // Vertices, of the trial and in its progress, have the world's motion taken out where cameras move; poses do not.
  // Throws InputError when the strategy is unknown or refuses the problem.
  std::function<RoundTrial(const std::string& strategy, const OnProgress& on_progress)> solve;
};

// The problem of a round: every term's blocks, and after SupportIsKnown() vertices on their lines where
// they move along normals, and constant where they do not. Cameras that the parameters have move as PoseManifold
// says. What the terms have left to freeze is made beside
// that. `terms`, `context` and `parameters` must outlive it.
class RoundProblem {
 public:
  RoundProblem(const TermRounds& terms, const RoundContext& context, RoundParameters* parameters);
  RoundProblem(const RoundProblem&) = delete;
  RoundProblem& operator=(const RoundProblem&) = delete;

  // The context's `supported` and `moves` are final. To be called once, before anything below.
  void SupportIsKnown();

  int Unknowns() const { return unknowns_; }  // of the vertices and cameras that may move
  // At the vertices' current positions, and their "total".
  nlohmann::json EnergyByTerm() const;
  int64_t WindowCount() const;  // of all terms, where they were evaluated last
  // Solves a copy of the task from `start` and the cameras where they are, with nothing evaluated yet, and leaves
  // both there again. Energies before and after are outside clock and count. See FrozenRound::solve.
  RoundTrial Try(const Strategy& strategy, const SolverOptions& options,
                 const std::vector<Eigen::Vector3d>& start,
                 const FrozenRound::OnProgress& on_progress) const;

  SolveTask task;

 private:
  const TermRounds& terms_;
  RoundEnergy energy_;
  std::unique_ptr<ceres::EvaluationCallback> callback_;
  std::vector<LineAlongNormal> lines_;
  PoseManifold pose_motion_;
  int unknowns_ = 0;
};

// The strategy of that name; throws InputError when there is none or it cannot take the problem.
const Strategy& StrategyFor(const std::string& name, int unknowns, const SolverOptions& options);

}  // namespace burin
