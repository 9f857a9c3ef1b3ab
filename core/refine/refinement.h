// The coarse-to-fine loop: levels of the image pyramid, on each the mesh is cut to the level's
// pixels, then rounds of freezing visibility and minimising the sum of the energy terms.
//
// Everything runs in a normalised world, X' = (X - origin) / footprint, with origin the middle of
// the mesh's bounding box and footprint the median over vertices of the smallest pixel footprint at
// full resolution. One unit is about one pixel, so no tolerance, step or weight has a scale.
//
// Every level gets more rounds than the next finer one, and a finer tolerance than the finest. What
// is many pixels off - a facet that bridges a depth step, a niche that the initial mesh covers - can
// only move there, within the few pixels over which windows correlate, and moves far only when
// visibility is frozen anew on the way; the rest of the mesh has converged by then and the sum's
// relative tolerance no longer notices. A level has a quarter of the pixels of the next, so this
// costs little. Images with less than min_side_px are not used: smoothness, which does not shrink
// with the pixels, would be all there is.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/refine/frozen_round.h"
#include "core/refine/level_judge.h"
#include "core/refine/local_guard.h"
#include "core/refine/refinement_state.h"
#include "core/scene/pairs.h"
#include "core/scene/scene.h"
#include "core/solve/energy_term.h"
#include "core/solve/solver_strategy.h"
#include "core/support/options.h"

namespace burin {

struct LevelOptions {
  int count = 5;                   // images at 2^-(count-1), ..., 1/2, 1 of their size
  int min_side_px = 64;            // coarser levels with smaller images than this are not used
  int finest = 0;                  // 0 = full resolution, 1 = half, ...
  int rounds = 2;                  // on the finest level
  int extra_rounds = 2;            // more on every level than on the next finer one
  double coarse_tolerance = 1e-4;  // solver.function_tolerance on the others
  double max_facet_px = 16;        // facets are split down to this area, square pixels of the level
  double max_edge_px = 12;         // and edges to this length, pixel footprints of the level
  double border_px = 3;            // second-view points nearer to the border are left out
  void Describe(OptionSet* set);
};

// What becomes of vertices that a pair saw in an earlier round and none sees now
// (core/refine/hidden_folds.h): drawn together, or they keep their shape as those never seen do.
enum class HiddenVertices { kRelax, kKeep };
inline Choices<HiddenVertices> ChoicesOf(HiddenVertices) {
  return {{HiddenVertices::kRelax, "relax"}, {HiddenVertices::kKeep, "keep"}};
}

struct RefinementOptions {
  LevelOptions level;
  SolverOptions solver;
  GuardOptions guard;
  Motion motion = Motion::kNormal;
  HiddenVertices hidden = HiddenVertices::kRelax;
  void Describe(OptionSet* set);
};

// Position within a run, for progress and the trace.
struct RefinementEvent {
  int level = 0;
  int round = 0;
  double done = 0;  // estimated share of the whole run's work
  IterationRecord iteration;
};

// The refined mesh with a frozen round, which the terms have begun: the last one, or one made for this
// mesh where that one was not of it (the run was stopped, the level undone).
struct RefinementEnd {
  const RoundContext* context = nullptr;
  int level = 0;                                // of the pyramid, the context's
  const TriangleMesh* mesh = nullptr;           // normalised world, in the context's order
  std::vector<Eigen::Vector3d> input_position;  // where on the input its vertices lay
  std::vector<int> index;  // in the mesh that Refine() returns, of every vertex
};

struct RefinementHooks {
  // After every iteration; false stops the refinement after this iteration with the mesh so far.
  std::function<bool(const RefinementEvent&)> on_iteration;
  // After every round, with the frozen state of the round and the mesh it ended with, both in the
  // normalised world.
  std::function<void(const RoundContext&, const TriangleMesh&, const RoundSummary&)> on_round;
  // Solves a round in place of options.solver.type; the refinement goes on with what it returns.
  // It may try several strategies on the round. Called instead of on_iteration; the figures of
  // RoundSummary::terms are then over all trials.
  std::function<RoundTrial(const FrozenRound&)> solve_round;
  // Decides after every level; null: every level stands.
  LevelJudge* judge = nullptr;
  // Before Refine() returns.
  std::function<void(const RefinementEnd&)> on_end;
  // After every level, with the mesh in the caller's world.
  std::function<void(const LevelSummary&, const TriangleMesh&)> on_level;
  // After every round that ran to its end but the last, with what Refine() needs to go on from there.
  std::function<void(const RefinementState&)> on_state;
};

// Median over vertices of the smallest pixel footprint, full resolution, among the views that they
// project into; 0 when none does.
double MedianFootprint(const Scene& scene, const TriangleMesh& mesh);

// Moves (and adds) vertices of `input` so that the sum of the terms falls. Terms are not owned.
// With `start`, a state that on_state was given by a refinement of the same scene, mesh, pairs,
// options and terms, it goes on from there and comes to the same bytes; seconds in the summary are
// summed over both. Throws InputError when the pairs see nothing of the mesh or an option does not
// fit the data.
TriangleMesh Refine(const Scene& scene, const TriangleMesh& input,
                    const std::vector<CameraPair>& pairs, const RefinementOptions& options,
                    const std::vector<EnergyTerm*>& terms, const RefinementHooks& hooks,
                    RefinementSummary* summary, const RefinementState* start = nullptr);

}  // namespace burin
