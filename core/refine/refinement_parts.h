// What a refinement is put together from besides its data and options, and who looks on.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/refine/frozen_round.h"
#include "core/refine/level_judge.h"
#include "core/refine/refinement_state.h"
#include "core/solve/energy_term.h"

namespace burin {

// What decides the result. Nothing is owned.
struct RefinementParts {
  std::vector<EnergyTerm*> terms;
  // Of the scene's views, to start with; empty: as the scene has them.
  std::vector<Camera> cameras;
  // Of the scene's views where `cameras` have refined intrinsics; else empty. It goes to RefinementSummary::lenses only.
  std::vector<Lens> lenses;
  // Decides after every level; null: every level stands.
  LevelJudge* judge = nullptr;
  // Solves a round in place of options.solver.type; the refinement goes on with what it returns. It may
  // try several strategies on the round; the figures of RoundSummary::terms are then over all trials.
  std::function<RoundTrial(const FrozenRound&)> solve_round;
};

// Position within a run, for progress and the trace.
struct RefinementEvent {
  int level = 0;
  int round = 0;
  double done = 0;  // estimated share of the whole run's work
  IterationRecord iteration;
  int64_t windows = 0;  // at the start of the round: what its energies are sums over
};

// The refined mesh with a frozen round: the last one, or one made for this mesh where that one was not
// of it (the level was undone).
struct RefinementEnd {
  const RoundContext* context = nullptr;
  const TermRounds* terms = nullptr;             // in that round
  int level = 0;                                 // of the pyramid, the context's
  const std::vector<Camera>* cameras = nullptr;  // of the scene's views, caller's world
  const TriangleMesh* mesh = nullptr;            // normalised world, in the context's order
  std::vector<Eigen::Vector3d> input_position;   // where on the input its vertices lay
  std::vector<int> part;        // of every vertex: RefinementState::part; empty where that is
  std::vector<int> index;       // in the mesh that Refine() returns, of every vertex
  std::vector<int> face_index;  // likewise, of every facet
};

// Who looks on. None of these changes the result, but that on_iteration may end the run.
struct RefinementObservers {
  // After every iteration, those of RefinementParts::solve_round's trials too; false stops the refinement
  // after this iteration with the mesh so far.
  std::function<bool(const RefinementEvent&)> on_iteration;
  // After every round, with the frozen state of the round and the mesh it ended with, both in the
  // normalised world.
  std::function<void(const RoundContext&, const TriangleMesh&, const RoundSummary&)> on_round;
  // After every level, one that the run was stopped in too, with the mesh in the caller's world.
  std::function<void(const LevelSummary&, const TriangleMesh&)> on_level;
  // After every round that ran to its end but the last, with what Refine() needs to go on from there.
  std::function<void(const RefinementState&)> on_state;
  // Before Refine() returns.
  std::function<void(const RefinementEnd&)> on_end;
};

}  // namespace burin
