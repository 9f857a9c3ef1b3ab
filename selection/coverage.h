// How many camera pairs see each facet, and the paper's Algorithm 1. The algorithm gives up a little of the
// pairs' energy so that more pairs see the mesh, and see it more evenly.
//
//   V_f = number of directed pairs (i, j) of the set whose two views both see facet f
//   mu, sigma = mean and standard deviation of V_f over the facets
#pragma once

#include <string>
#include <vector>

#include "core/scene/pairs.h"
#include "selection/facet_sets.h"

namespace burin {

// V_f of a set of pairs that changes, with its mean and spread kept in integers: exact, whatever the
// order of the changes.
class Coverage {
 public:
  // Over the facets that at least two views see, or over all. `seen` must outlive this.
  Coverage(const FacetSets& seen, int view_count, bool visible_only);

  void Add(const CameraPair& pair) { Change(pair, 1); }
  void Remove(const CameraPair& pair) { Change(pair, -1); }

  double Mean() const;
  double StdDev() const;                                      // of the population
  const std::vector<int>& Counts() const { return counts_; }  // V_f, all facets
  // Share of the facets counted over that at least one pair sees.
  double CoveredShare() const;

 private:
  void Change(const CameraPair& pair, int step);

  const FacetSets* seen_;
  std::vector<int> counts_;
  int64_t facets_ = 0;  // counted over
  int64_t sum_ = 0;
  int64_t sum_of_squares_ = 0;
};

// Switches where the print contradicts its text; the defaults are the correction, and what each
// printed form does instead is said beside it.
struct SwapOptions {
  // A swap is taken while the energies sum to at most this share of those of the initial pairs
  // (sums are negative: 0.9 gives up a tenth).
  double energy_fraction = 0.9;
  // Printed: the loop runs while the sum is above energy_fraction * E_ref, which for negative sums
  // is false at once, so nothing is ever swapped.
  bool printed_energy_test = false;
  // Printed: a camera's set of used partners begins empty, so the best unused partner is the
  // present one.
  bool printed_used_partners = false;
  // Printed: every swap starts from the initial pairs and every sweep from their mu and sigma, so
  // that earlier swaps vanish.
  bool printed_state = false;
  // Printed: mu must grow and sigma shrink; corrected (the authors' program): mu must not shrink.
  bool printed_coverage_test = false;
  // Printed: over all facets; corrected: over those that two views see. The others keep V_f = 0, so
  // that sigma grows with mu whatever is swapped.
  bool printed_facets = false;
};

struct SwapTrial {
  int sweep = 0;
  int reference = -1;
  int from = -1;  // the partner tried to give up
  int to = -1;    // and the one tried instead
  bool accepted = false;
  double mean = 0;    // coverage if accepted
  double stddev = 0;  // coverage if accepted
  double energy = 0;  // sum over the pairs if accepted
  std::string reason;
};

struct SwapResult {
  std::vector<CameraPair> pairs;  // in the order of the initial ones
  std::vector<SwapTrial> trials;
};

// Algorithm 1. energies[i * view_count + j] is E_BPV, 0 for pairs that are no candidates. For
// every camera with several partners each is tried, the last (worst) first; with one partner this
// is the printed loop. Ties between partners go to the lower index.
SwapResult ImproveCoverage(const std::vector<CameraPair>& initial,
                           const std::vector<double>& energies, int view_count,
                           const FacetSets& seen, const SwapOptions& options);

}  // namespace burin
