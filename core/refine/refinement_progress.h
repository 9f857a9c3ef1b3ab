// How far a refinement is: time, the share of its work that is done, and whether it was told to stop.
#pragma once

#include "core/refine/refinement_options.h"
#include "core/refine/refinement_state.h"
#include "core/support/stopwatch.h"

namespace burin {

// Rounds of a level at a stage. `more` are added before the surface is cut anew.
int RoundsOf(const RefinementOptions& options, int level, LevelStage stage, int more = 0);

// Those of them that are counted on: all but what follows where the guard undoes a surface cut anew.
int PlannedRounds(const RefinementOptions& options, int level, LevelStage stage);

class RefinementProgress {
 public:
  // Of a refinement from level `first_level` on that begins, or goes on, at `start`.
  RefinementProgress(const RefinementOptions& options, int first_level,
                     const RefinementState& start);

  void RoundDone(int level) { done_ += WorkOf(level); }
  // This many of the level's rounds will not be run.
  void RoundsSpared(int level, int rounds) { total_ -= rounds * WorkOf(level); }
  // Of the whole run's work, with this share of the round in work.
  double Share(int level, double share_of_round) const {
    return (done_ + share_of_round * WorkOf(level)) / total_;
  }
  double Seconds() const { return seconds_before_ + watch_.Seconds(); }  // of all its parts

  void Stop() { stopped_ = true; }
  bool stopped() const { return stopped_; }

 private:
  static double WorkOf(int level);  // of a round: in proportion to the level's pixels

  const Stopwatch watch_;
  const double seconds_before_;
  double total_ = 0;
  double done_ = 0;
  bool stopped_ = false;
};

}  // namespace burin
