#include "selection/coverage.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace burin {

Coverage::Coverage(const FacetSets& seen, int view_count, bool visible_only)
    : seen_(&seen), counts_(seen.facet_count(), 0), facets_(seen.facet_count()) {
  if (!visible_only) return;
  facets_ = 0;
  for (int f = 0; f < seen.facet_count(); ++f) {
    int views = 0;
    for (int i = 0; i < view_count && views < 2; ++i) views += seen.Contains(i, f) ? 1 : 0;
    if (views == 2) ++facets_;
  }
}

void Coverage::Change(const CameraPair& pair, int step) {
  seen_->ForEachShared(pair.reference, pair.second, [&](int facet) {
    int& count = counts_[facet];
    sum_ += step;
    sum_of_squares_ += 2 * step * count + 1;  // (count + step)^2 - count^2
    count += step;
  });
}

double Coverage::Mean() const {
  return facets_ == 0 ? 0 : static_cast<double>(sum_) / static_cast<double>(facets_);
}

double Coverage::StdDev() const {
  if (facets_ == 0) return 0;
  const double mean = Mean();
  const double square = static_cast<double>(sum_of_squares_) / static_cast<double>(facets_);
  return std::sqrt(std::max(0.0, square - mean * mean));
}

double Coverage::CoveredShare() const {
  if (facets_ == 0) return 0;
  int64_t covered = 0;
  for (const int count : counts_) covered += count > 0 ? 1 : 0;
  return static_cast<double>(covered) / static_cast<double>(facets_);
}

namespace {

class Algorithm1 {
 public:
  Algorithm1(const std::vector<CameraPair>& initial, const std::vector<double>& energies,
             int view_count, const FacetSets& seen, const SwapOptions& options)
      : initial_(initial),
        energies_(energies),
        view_count_(view_count),
        options_(options),
        coverage_(seen, view_count, !options.printed_facets),
        used_(static_cast<size_t>(view_count) * view_count, 0) {
    result_.pairs = initial;
    for (const CameraPair& pair : initial) {
      coverage_.Add(pair);
      energy_ += Energy(pair);
      if (!options.printed_used_partners) Used(pair) = 1;
    }
    energy_reference_ = energy_;
    initial_mean_ = mean_ = coverage_.Mean();
    initial_stddev_ = stddev_ = coverage_.StdDev();
  }

  SwapResult Run() {
    bool changed = true;
    for (int sweep = 0; changed && LoopGoesOn(); ++sweep) {
      changed = false;
      if (options_.printed_state) {
        mean_ = initial_mean_;
        stddev_ = initial_stddev_;
      }
      // The partners of a camera stand together, best first.
      for (size_t first = 0, last = 0; first < initial_.size(); first = last) {
        while (last < initial_.size() && initial_[last].reference == initial_[first].reference) {
          ++last;
        }
        for (size_t slot = last; slot-- > first;) {
          if (options_.printed_state) RestoreInitialPairs();
          changed = Try(slot, sweep) || changed;
        }
      }
    }
    return result_;
  }

 private:
  bool LoopGoesOn() const {
    return !options_.printed_energy_test || energy_ > options_.energy_fraction * energy_reference_;
  }

  double Energy(const CameraPair& pair) const {
    return energies_[static_cast<size_t>(pair.reference) * view_count_ + pair.second];
  }
  char& Used(const CameraPair& pair) {
    return used_[static_cast<size_t>(pair.reference) * view_count_ + pair.second];
  }

  // The candidate of least energy that the camera has not used and that none of its other slots
  // holds; -1 for none.
  int BestUnused(size_t slot) {
    const int reference = result_.pairs[slot].reference;
    int best = -1;
    for (int j = 0; j < view_count_; ++j) {
      const CameraPair pair = {reference, j};
      if (Energy(pair) >= 0 || Used(pair) != 0) continue;
      const auto holder = std::find(result_.pairs.begin(), result_.pairs.end(), pair);
      if (holder != result_.pairs.end() &&
          holder != result_.pairs.begin() + static_cast<long>(slot)) {
        continue;
      }
      if (best < 0 || Energy(pair) < Energy({reference, best})) best = j;
    }
    return best;
  }

  void RestoreInitialPairs() {
    for (size_t k = 0; k < initial_.size(); ++k) {
      if (result_.pairs[k] == initial_[k]) continue;
      coverage_.Remove(result_.pairs[k]);
      coverage_.Add(initial_[k]);
      result_.pairs[k] = initial_[k];
    }
  }

  std::string Refusal(const SwapTrial& trial) const {
    const bool strict = options_.printed_coverage_test;
    if (strict ? trial.mean <= mean_ : trial.mean < mean_) {
      return strict ? "mean coverage does not grow" : "mean coverage would fall";
    }
    if (trial.stddev >= stddev_) return "spread of coverage does not fall";
    if (!options_.printed_energy_test &&
        trial.energy > options_.energy_fraction * energy_reference_) {
      return "energy would give up more than allowed";
    }
    return "";
  }

  bool Try(size_t slot, int sweep) {
    const CameraPair old_pair = result_.pairs[slot];
    const int candidate = BestUnused(slot);
    if (candidate < 0) return false;
    const CameraPair new_pair = {old_pair.reference, candidate};
    coverage_.Remove(old_pair);
    coverage_.Add(new_pair);
    SwapTrial trial;
    trial.sweep = sweep;
    trial.reference = old_pair.reference;
    trial.from = old_pair.second;
    trial.to = candidate;
    trial.mean = coverage_.Mean();
    trial.stddev = coverage_.StdDev();
    trial.energy = energy_ + Energy(new_pair) - Energy(old_pair);
    trial.reason = Refusal(trial);
    trial.accepted = trial.reason.empty();
    if (trial.accepted) {
      trial.reason = "coverage grows or stays, its spread falls";
      result_.pairs[slot] = new_pair;
      Used(new_pair) = 1;
      energy_ = trial.energy;
      mean_ = trial.mean;
      stddev_ = trial.stddev;
    } else {
      coverage_.Remove(new_pair);
      coverage_.Add(old_pair);
    }
    result_.trials.push_back(trial);
    return trial.accepted;
  }

  const std::vector<CameraPair>& initial_;
  const std::vector<double>& energies_;
  int view_count_;
  SwapOptions options_;
  Coverage coverage_;
  std::vector<char> used_;
  double energy_ = 0;
  double energy_reference_ = 0;
  double mean_ = 0;  // what the next trial is compared with
  double stddev_ = 0;
  double initial_mean_ = 0;
  double initial_stddev_ = 0;
  SwapResult result_;
};

}  // namespace

SwapResult ImproveCoverage(const std::vector<CameraPair>& initial,
                           const std::vector<double>& energies, int view_count,
                           const FacetSets& seen, const SwapOptions& options) {
  return Algorithm1(initial, energies, view_count, seen, options).Run();
}

}  // namespace burin
