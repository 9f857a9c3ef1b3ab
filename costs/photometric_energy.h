// The photometric energy as a term: options and the images of the level. What it is in a round, and the
// formulas, are in costs/photometric_round.h.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/solve/energy_term.h"
#include "costs/photometric_options.h"
#include "costs/photometric_round.h"
#include "costs/view_evaluation.h"

namespace burin {

class PhotometricEnergy : public EnergyTerm {
 public:
  // With `hold_back_squares` the windows of HeldBackSquares are left out of the energy with all their
  // taps: they are then what is held back, instead of the context's pairs.
  explicit PhotometricEnergy(const PhotometricOptions& options, bool hold_back_squares = false);
  ~PhotometricEnergy() override;

  std::string Name() const override { return "photometric"; }
  void BeginLevel(const std::vector<LevelView>& views) override;
  std::unique_ptr<TermRound> Freeze(const RoundContext& context) override;

  // The same with its own type; and of rounds that Freeze() has made.
  std::unique_ptr<PhotometricRound> FreezeRound(const RoundContext& context);
  PhotometricRound& RoundOf(const TermRounds& rounds) const;

 private:
  const PhotometricOptions options_;
  const bool hold_back_squares_;
  std::unique_ptr<ViewEvaluation> view_evaluation_;
  const std::vector<LevelView>* views_ = nullptr;
};

}  // namespace burin
