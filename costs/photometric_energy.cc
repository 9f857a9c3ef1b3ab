#include "costs/photometric_energy.h"

#include <glog/logging.h>

namespace burin {

PhotometricEnergy::PhotometricEnergy(const PhotometricOptions& options, bool hold_back_squares)
    : options_(options),
      hold_back_squares_(hold_back_squares),
      view_evaluation_(ViewEvaluation::Make(options)) {}

PhotometricEnergy::~PhotometricEnergy() = default;

void PhotometricEnergy::BeginLevel(const std::vector<LevelView>& views) {
  views_ = &views;
  view_evaluation_->BeginLevel(views);
}

std::unique_ptr<PhotometricRound> PhotometricEnergy::FreezeRound(const RoundContext& context) {
  CHECK(context.views == views_) << "the round's views are not those of the level";
  return std::make_unique<PhotometricRound>(options_, hold_back_squares_, view_evaluation_.get(),
                                            context);
}

std::unique_ptr<TermRound> PhotometricEnergy::Freeze(const RoundContext& context) {
  return FreezeRound(context);
}

PhotometricRound& PhotometricEnergy::RoundOf(const TermRounds& rounds) const {
  return static_cast<PhotometricRound&>(rounds.Of(this));
}

}  // namespace burin
