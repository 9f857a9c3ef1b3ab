#include "core/refine/refinement_progress.h"

#include <cmath>

namespace burin {

double RefinementProgress::WorkOf(int level) { return std::ldexp(1.0, -2 * level); }

RefinementProgress::RefinementProgress(const RefinementOptions& options, int first_level,
                                       const RefinementState& start)
    : seconds_before_(start.summary.seconds) {
  const auto add = [&](int level, int rounds, bool is_before, bool is_here) {
    total_ += rounds * WorkOf(level);
    if (is_before) done_ += rounds * WorkOf(level);
    if (is_here) done_ += start.round * WorkOf(level);
  };
  const LevelOptions& levels = options.level;
  for (int level = first_level; level >= levels.finest; --level) {
    add(level, levels.RoundsAt(level), level > start.level || start.remeshing > 0,
        level == start.level && start.remeshing == 0);
  }
  if (options.surface.remesh == SurfaceFacets::kNone) return;
  add(levels.finest, options.surface.rounds, start.level<levels.finest, start.remeshing> 0);
}

}  // namespace burin
