// Whether a level of the refinement improved the mesh, judged by data it did not see: camera pairs
// that were not used, or else small squares of the images that were left out.
//
// Both meshes have the same facets. On the windows that fall into a facet, of the visibility frozen
// in the level's first round for the mesh before and in its last round for the mesh after,
//
//   e(mesh) = sum omega (1 - z) / sum omega
//
// so that both are scored on the same piece of surface; facets that one of them leaves without
// windows do not count. The change is the mean of e(after) - e(before) over facets, weighted by the
// smaller sum of omega; its standard error comes from the spread over 64 batches of neighbouring facets.
#pragma once

#include <utility>
#include <vector>

#include "core/refine/level_judge.h"
#include "costs/photometric_energy.h"

namespace burin {

struct HeldBackVerdict {
  double before = 0;  // weighted mean of 1 - z
  double after = 0;
  double standard_error = 0;  // of after - before
  double windows = 0;         // sum of the weights
  int batches = 0;            // with windows, of which the standard error is
  // By more than two standard errors: pairs that do not correlate on either mesh say nothing. Nor does
  // what lies in a few batches, whose spread is no measure.
  bool Worse() const { return batches >= 8 && after - before > 2 * standard_error; }
};

// By facet; neighbouring facets have neighbouring indices.
HeldBackVerdict CompareScores(const std::vector<FacetScore>& before,
                              const std::vector<FacetScore>& after);

class HeldBackJudge : public LevelJudge {
 public:
  // By `pairs`; where there are none, by squares, which `photometric` holds back then. It is a term of
  // the refinement and not owned.
  HeldBackJudge(std::vector<CameraPair> pairs, const PhotometricEnergy* photometric)
      : pairs_(std::move(pairs)), photometric_(photometric) {}

  const std::vector<CameraPair>& HeldBackPairs() const override { return pairs_; }
  void BeginLevel(const RoundContext& first, const TermRounds& terms) override;
  LevelVerdict EndLevel(const RoundContext& last, const TermRounds& terms,
                        const TriangleMesh& after) override;

 private:
  const std::vector<CameraPair> pairs_;
  const PhotometricEnergy* const photometric_;
  std::vector<FacetScore> before_;
  double seconds_ = 0;
};

}  // namespace burin
