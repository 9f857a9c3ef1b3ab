// Rounds of a level that somebody else solves (RefinementParts::solve_round), and the world's motion in those that move
// cameras.
#include <utility>

#include "core/mesh/mesh_order.h"
#include "core/refine/camera_rounds.h"
#include "core/refine/level.h"
#include "core/support/error.h"

namespace burin {

double Level::TakeWorld(const RefinementState& state, const std::vector<CameraPose>& poses,
                        std::vector<Eigen::Vector3d>* vertices,
                        std::vector<Camera>* cameras) const {
  return TakeCameras(frozen_->context, state.summary.first_cameras, task_.world, poses, vertices,
                     cameras);
}

RoundTrial Level::SolveByPart(const RefinementState& state, RefinementProgress* progress,
                              RoundProblem* problem) {
  const int unknowns = problem->Unknowns();
  FrozenRound round;
  round.level = level_;
  round.round = RoundNumber(state);
  round.unknowns = unknowns;
  const std::vector<CameraPose>& poses = problem->task.energy->parameters().cameras;
  round.cameras = static_cast<int>(poses.size());
  round.context = &frozen_->context;
  round.world_mesh = [&](const std::vector<Eigen::Vector3d>& now) {
    TriangleMesh moved = state.mesh;
    RestoreVertices({now, {}}, state.order, &moved);
    return task_.world.ToWorld(std::move(moved));
  };
  round.solve = [&](const std::string& name, const FrozenRound::OnProgress& on_progress) {
    const Strategy& strategy = StrategyFor(name, unknowns, solver_);
    if (!poses.empty() && !strategy.moves_cameras) {
      throw InputError("solver.type = " + strategy.name + ": does not move cameras");
    }
    std::vector<Camera> unused = state.summary.cameras;
    FrozenRound::OnProgress both = on_progress;
    if (on_progress && !poses.empty()) {
      both = [&](const FrozenRound::Progress& trial) {
        std::vector<Eigen::Vector3d> vertices = *trial.vertices;
        FrozenRound::Progress moved = trial;
        moved.vertices = &vertices;
        moved.camera_px = TakeWorld(state, poses, &vertices, &unused);
        return on_progress(moved);
      };
    }
    if (task_.observers.on_iteration) {
      both = [&, own = both](const FrozenRound::Progress& trial) {
        const bool goes_on = !own || own(trial);
        return Report(trial.record, round.round, progress) && goes_on;
      };
    }
    RoundTrial trial = problem->Try(strategy, solver_, mesh_.vertices, both);
    if (!poses.empty()) {
      trial.camera_px = TakeWorld(state, trial.cameras, &trial.vertices, &unused);
    }
    return trial;
  };
  return task_.parts.solve_round(round);
}

}  // namespace burin
