#include "core/refine/refinement.h"

#include <glog/logging.h>
#include <malloc.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "core/refine/level.h"
#include "core/refine/normalized_world.h"
#include "core/refine/refinement_progress.h"
#include "core/support/error.h"

namespace burin {
namespace {

// A round frees millions of small blocks (residuals, Jacobian cells) that the next level's large arrays
// cannot use; give their pages back instead of carrying them through the run.
void ReturnFreeMemory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

RefinementState FirstState(const RefinementTask& task, const TriangleMesh& input) {
  RefinementState state;
  state.level = task.first_level;
  state.mesh = task.world.FromWorld(input);
  state.input_position = state.mesh.vertices;
  state.was_supported.assign(input.vertices.size(), 0);
  state.summary.footprint = task.world.footprint;
  state.summary.cameras = task.parts.cameras.empty() ? CamerasOf(task.scene) : task.parts.cameras;
  state.summary.first_cameras = state.summary.cameras;
  state.summary.lenses = task.parts.lenses;
  return state;
}

// The finest level's last rounds are another level on a surface cut anew, where some level has moved anything; that is followed
// by a finer one where the guard undid it, and by one on the surface as it was.
bool FinestGoesOn(const RefinementOptions& options, const RefinementState& state) {
  const std::vector<LevelSummary>& levels = state.summary.levels;
  if (options.surface.remesh == SurfaceFacets::kNone || state.level != options.level.finest) {
    return false;
  }
  switch (state.stage) {
    case LevelStage::kGiven:
      return std::any_of(levels.begin(), levels.end(), [](const LevelSummary& level) {
        return !level.left_out && !level.undone;
      });
    case LevelStage::kCutAnew:
      return levels.back().undone;
    case LevelStage::kCutFiner:
      return levels.back().undone && RoundsOf(options, state.level, LevelStage::kAsTheyWere) > 0;
    case LevelStage::kAsTheyWere:
      break;
  }
  return false;
}

}  // namespace

TriangleMesh Refine(const Scene& scene, const TriangleMesh& input,
                    const std::vector<CameraPair>& pairs, const RefinementOptions& options,
                    const RefinementParts& parts, const RefinementObservers& observers,
                    RefinementSummary* summary, const RefinementState* start) {
  CHECK(!input.vertices.empty());
  RefinementTask task{scene,
                      pairs,
                      options,
                      parts,
                      observers,
                      NormalizedWorld::Of(scene, input),
                      ViewLevels(scene, input, options.level)};
  if (task.world.footprint <= 0) {
    throw InputError("no vertex of the mesh projects into any of the " +
                     std::to_string(scene.views.size()) +
                     " views: mesh and cameras are not in the same coordinate frame");
  }
  task.first_level = task.view_levels.Coarsest(
      pairs, parts.judge != nullptr ? parts.judge->HeldBackPairs() : std::vector<CameraPair>());
  RefinementState state = start != nullptr ? *start : FirstState(task, input);
  CHECK_EQ(state.summary.cameras.size(), scene.views.size());
  RefinementProgress progress(options, task.first_level, state);
  std::unique_ptr<Level> level;
  while (state.level >= options.level.finest && !progress.stopped()) {
    if (level == nullptr || state.stage == LevelStage::kGiven) {
      level.reset();
      ReturnFreeMemory();
      level = std::make_unique<Level>(task, state.level, state.summary.cameras);
    }
    level->Run(&state, &progress);
    if (progress.stopped()) break;
    if (FinestGoesOn(options, state)) {
      state.stage = static_cast<LevelStage>(static_cast<int>(state.stage) + 1);
    } else if (--state.level < options.level.finest) {
      break;
    }
    state.round = 0;
    state.order = MeshOrder();
    if (observers.on_state) observers.on_state(state);
  }
  const std::vector<LevelSummary>& levels = state.summary.levels;
  if (std::all_of(levels.begin(), levels.end(),
                  [](const LevelSummary& of) { return of.left_out; })) {
    throw InputError(
        "no camera pair sees a common part of the mesh at any level: every facet is out of view, "
        "hidden, masked, seen from behind or too small for a window");
  }
  if (level == nullptr)
    level = std::make_unique<Level>(task, options.level.finest, state.summary.cameras);
  level->ShowEnd(&state);
  *summary = std::move(state.summary);
  return task.world.ToWorld(std::move(state.mesh));
}

}  // namespace burin
