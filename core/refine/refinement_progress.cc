#include "core/refine/refinement_progress.h"

#include <cmath>

namespace burin {

double RefinementProgress::WorkOf(int level) { return std::ldexp(1.0, -2 * level); }

RefinementProgress::RefinementProgress(const RefinementOptions& options, int first_level,
                                       const RefinementState& start)
    : seconds_before_(start.summary.seconds) {
  const auto add = [&](int level, int remeshing) {
    const int rounds = PlannedRounds(options, level, remeshing);
    const bool is_here = level == start.level && remeshing == start.remeshing;
    const bool is_before =
        level > start.level || (level == start.level && remeshing < start.remeshing);
    total_ += rounds * WorkOf(level);
    if (is_before) done_ += rounds * WorkOf(level);
    if (is_here) done_ += start.round * WorkOf(level);
  };
  for (int level = first_level; level >= options.level.finest; --level) add(level, 0);
  add(options.level.finest, 1);
}

int PlannedRounds(const RefinementOptions& options, int level, int remeshing) {
  const RemeshingOptions& surface = options.surface;
  if (remeshing > 1) return 0;
  if (remeshing == 1) return surface.remesh == SurfaceFacets::kNone ? 0 : surface.rounds;
  const int rounds = options.level.RoundsAt(level);
  return level == options.level.finest ? surface.RoundsBefore(rounds) : rounds;
}

}  // namespace burin
