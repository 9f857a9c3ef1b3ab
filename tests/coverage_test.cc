// Coverage of facets by pairs, and Algorithm 1 on cases that are small enough to do by hand.
#include "selection/coverage.h"

#include <gtest/gtest.h>

#include <cmath>

namespace burin {
namespace {

FacetSets Sets(const std::vector<std::vector<int>>& facets_of_views, int facet_count) {
  FacetSets sets(static_cast<int>(facets_of_views.size()), facet_count);
  for (size_t i = 0; i < facets_of_views.size(); ++i) {
    for (const int facet : facets_of_views[i]) sets.Insert(static_cast<int>(i), facet);
  }
  return sets;
}

TEST(FacetSets, SharedFacetsAreThoseOfBoth) {
  const FacetSets sets = Sets({{0, 5, 63, 64, 129}, {5, 64, 128, 129}}, 130);
  EXPECT_EQ(sets.CountShared(0, 1), 3);
  std::vector<int> shared;
  sets.ForEachShared(1, 0, [&](int facet) { shared.push_back(facet); });
  EXPECT_EQ(shared, (std::vector<int>{5, 64, 129}));
}

TEST(Coverage, CountsDirectedPairsAndTheirMoments) {
  // Facet 3 is seen by one view only, facet 4 by none.
  const FacetSets sets = Sets({{0, 1, 2}, {1, 2, 3}, {2}}, 5);
  Coverage visible(sets, 3, true);
  Coverage all(sets, 3, false);
  for (Coverage* coverage : {&visible, &all}) {
    coverage->Add({0, 1});
    coverage->Add({1, 0});
    coverage->Add({2, 1});
    EXPECT_EQ(coverage->Counts(), (std::vector<int>{0, 2, 3, 0, 0}));
  }
  EXPECT_NEAR(visible.Mean(), 2.5, 1e-12);
  EXPECT_NEAR(visible.StdDev(), 0.5, 1e-12);
  EXPECT_NEAR(visible.CoveredShare(), 1, 1e-12);
  EXPECT_NEAR(all.Mean(), 1, 1e-12);
  EXPECT_NEAR(all.StdDev(), std::sqrt((4 + 9) / 5.0 - 1), 1e-12);
  visible.Remove({2, 1});
  EXPECT_EQ(visible.Counts(), (std::vector<int>{0, 2, 2, 0, 0}));
  EXPECT_NEAR(visible.StdDev(), 0, 1e-12);
}

// Three views. View 0 sees facets 0..3, view 1 sees 0 and 1, view 2 sees 1, 2 and 3. The initial
// pairs all lean on view 1: V = (2, 3, 0, 0).
struct Case {
  FacetSets sets = Sets({{0, 1, 2, 3}, {0, 1}, {1, 2, 3}}, 4);
  std::vector<CameraPair> initial = {{0, 1}, {1, 0}, {2, 1}};
  // Rows: reference; the partner not chosen at first is a little worse.
  std::vector<double> energies = {0, -1.0, -0.95, -1.0, 0, -0.5, -0.98, -1.0, 0};
};

TEST(Algorithm1, SwapsWhatCoversMoreAndMoreEvenly) {
  const Case given;
  const SwapResult result =
      ImproveCoverage(given.initial, given.energies, 3, given.sets, SwapOptions());
  // Initially V = (2, 3, 0, 0). (0,1) -> (0,2): V = (1, 3, 1, 1), mean 1.25 -> 1.5, spread falls.
  // (1,0) -> (1,2) shares facet 1 only: the mean falls. (2,1) -> (2,0): V = (1, 3, 2, 2).
  EXPECT_EQ(result.pairs, (std::vector<CameraPair>{{0, 2}, {1, 0}, {2, 0}}));
  ASSERT_GE(result.trials.size(), 3U);
  EXPECT_TRUE(result.trials[0].accepted);
  EXPECT_NEAR(result.trials[0].mean, 1.5, 1e-12);
  EXPECT_NEAR(result.trials[0].energy, -2.95, 1e-12);
  EXPECT_FALSE(result.trials[1].accepted);
  EXPECT_EQ(result.trials[1].reason, "mean coverage would fall");
  EXPECT_TRUE(result.trials[2].accepted);
  EXPECT_NEAR(result.trials[2].mean, 2, 1e-12);
}

TEST(Algorithm1, StopsWhereTheEnergyWouldGiveUpTooMuch) {
  Case given;
  given.energies[0 * 3 + 2] = -0.6;  // sum -3 -> -2.6, above 0.9 times -3
  const SwapResult result =
      ImproveCoverage(given.initial, given.energies, 3, given.sets, SwapOptions());
  EXPECT_EQ(result.pairs[0].second, 1);
  EXPECT_EQ(result.trials[0].reason, "energy would give up more than allowed");
  SwapOptions generous;
  generous.energy_fraction = 0.8;
  EXPECT_EQ(ImproveCoverage(given.initial, given.energies, 3, given.sets, generous).pairs[0].second,
            2);
}

// Sums of energies are negative, so "while E_new > 0.9 E_ref" is false before the first sweep.
TEST(Algorithm1, AsPrintedNeverRuns) {
  const Case given;
  SwapOptions printed;
  printed.printed_energy_test = true;
  const SwapResult result = ImproveCoverage(given.initial, given.energies, 3, given.sets, printed);
  EXPECT_EQ(result.pairs, given.initial);
  EXPECT_TRUE(result.trials.empty());
}

// Even if the loop ran: the best unused partner is the present one, which changes nothing.
TEST(Algorithm1, WithAnEmptySetOfUsedPartnersTriesThePresentOne) {
  const Case given;
  SwapOptions printed;
  printed.printed_used_partners = true;
  const SwapResult result = ImproveCoverage(given.initial, given.energies, 3, given.sets, printed);
  EXPECT_EQ(result.pairs, given.initial);
  for (const SwapTrial& trial : result.trials) {
    EXPECT_EQ(trial.from, trial.to);
    EXPECT_FALSE(trial.accepted);
  }
}

TEST(Algorithm1, AsPrintedEarlierSwapsVanish) {
  Case given;
  SwapOptions printed;
  printed.printed_state = true;
  const SwapResult result = ImproveCoverage(given.initial, given.energies, 3, given.sets, printed);
  ASSERT_FALSE(result.trials.empty());
  EXPECT_TRUE(result.trials[0].accepted);  // camera 0 is swapped ...
  EXPECT_EQ(result.pairs[0].second, 1);    // ... and swapped back with the next camera
}

// Mean and spread stay, then the mean stays and the spread falls: printed refuses, corrected takes.
TEST(Algorithm1, TheCorrectedTestAllowsAnEqualMean) {
  // Pairs (0,1): facets {0}; (0,2): facets {1}; facet 0 is covered by (1,0) too.
  const FacetSets sets = Sets({{0, 1}, {0}, {1}}, 2);
  const std::vector<double> energies = {0, -1.0, -0.95, -1.0, 0, 0, -0.99, 0, 0};
  const std::vector<CameraPair> initial = {{0, 1}, {1, 0}};
  EXPECT_EQ(ImproveCoverage(initial, energies, 3, sets, SwapOptions()).pairs[0].second, 2);
  SwapOptions printed;
  printed.printed_coverage_test = true;
  const SwapResult refused = ImproveCoverage(initial, energies, 3, sets, printed);
  EXPECT_EQ(refused.pairs[0].second, 1);
  EXPECT_EQ(refused.trials[0].reason, "mean coverage does not grow");
}

// Facets that no pair can cover keep V_f = 0, and the spread grows with the mean: the same swap,
// from three to all four of the facets that can be covered, is taken among 4 and refused among 60.
TEST(Algorithm1, OverAllFacetsUnseenOnesBlockSwaps) {
  const std::vector<std::vector<int>> facets = {{0, 1, 2, 3}, {0, 1, 2}, {0, 1, 2, 3}};
  const std::vector<double> energies = {0, -1.0, -0.95, 0, 0, 0, 0, 0, 0};
  const auto partner = [&](int facet_count, bool printed) {
    SwapOptions options;
    options.printed_facets = printed;
    return ImproveCoverage({{0, 1}}, energies, 3, Sets(facets, facet_count), options)
        .pairs[0]
        .second;
  };
  EXPECT_EQ(partner(4, true), 2);
  EXPECT_EQ(partner(60, true), 1);
  EXPECT_EQ(partner(60, false), 2);
}

TEST(Algorithm1, SeveralPartnersAreTriedWorstFirstAndNeverTwice) {
  // Four views, camera 0 with two partners; views 1 and 2 see the same, view 3 what they do not.
  const FacetSets sets = Sets({{0, 1, 2}, {0}, {0}, {1, 2}}, 3);
  std::vector<double> energies(16, 0);
  energies[1] = -1.0;
  energies[2] = -0.99;
  energies[3] = -0.98;
  const SwapResult result = ImproveCoverage({{0, 1}, {0, 2}}, energies, 4, sets, SwapOptions());
  EXPECT_EQ(result.pairs, (std::vector<CameraPair>{{0, 1}, {0, 3}}));
}

}  // namespace
}  // namespace burin
