#include "core/refine/refinement_progress.h"

#include <cmath>

namespace burin {

double RefinementProgress::WorkOf(int level) { return std::ldexp(1.0, -2 * level); }

RefinementProgress::RefinementProgress(const LevelOptions& options, int first_level,
                                       const RefinementState& start)
    : seconds_before_(start.summary.seconds) {
  for (int level = first_level; level >= options.finest; --level) {
    total_ += options.RoundsAt(level) * WorkOf(level);
    if (level > start.level) done_ += options.RoundsAt(level) * WorkOf(level);
    if (level == start.level) done_ += start.round * WorkOf(level);
  }
}

}  // namespace burin
