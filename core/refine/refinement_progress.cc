#include "core/refine/refinement_progress.h"

#include <cmath>

namespace burin {

double RefinementProgress::WorkOf(int level) { return std::ldexp(1.0, -2 * level); }

RefinementProgress::RefinementProgress(const RefinementOptions& options, int first_level,
                                       const RefinementState& start)
    : seconds_before_(start.summary.seconds) {
  const auto add = [&](int level, LevelStage stage) {
    const int rounds = PlannedRounds(options, level, stage);
    const bool is_here = level == start.level && stage == start.stage;
    const bool is_before = level > start.level || (level == start.level && stage < start.stage);
    total_ += rounds * WorkOf(level);
    if (is_before) done_ += rounds * WorkOf(level);
    if (is_here) done_ += start.round * WorkOf(level);
  };
  for (int level = first_level; level >= options.level.finest; --level)
    add(level, LevelStage::kGiven);
  add(options.level.finest, LevelStage::kCutAnew);
}

int RoundsOf(const RefinementOptions& options, int level, LevelStage stage, int more) {
  if (stage == LevelStage::kCutAnew || stage == LevelStage::kCutFiner)
    return options.surface.rounds;
  const int all = options.level.RoundsAt(level) + more;
  const int before = level == options.level.finest ? options.surface.RoundsBefore(all) : all;
  return stage == LevelStage::kGiven ? before : all - before;
}

int PlannedRounds(const RefinementOptions& options, int level, LevelStage stage) {
  const bool planned =
      stage == LevelStage::kGiven ||
      (stage == LevelStage::kCutAnew && options.surface.remesh != SurfaceFacets::kNone);
  return planned ? RoundsOf(options, level, stage) : 0;
}

}  // namespace burin
