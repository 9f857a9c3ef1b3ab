#include "core/solve/energy_term.h"

#include <glog/logging.h>

#include <algorithm>

namespace burin {

TermRounds::TermRounds(const std::vector<EnergyTerm*>& terms, const RoundContext& context) {
  for (EnergyTerm* term : terms) entries_.push_back({term, term->Freeze(context)});
}

TermRound& TermRounds::Of(const EnergyTerm* term) const {
  const auto found = std::find_if(entries_.begin(), entries_.end(),
                                  [term](const Entry& entry) { return entry.term == term; });
  CHECK(found != entries_.end()) << term->Name() << " is not a term of this round";
  return *found->round;
}

}  // namespace burin
