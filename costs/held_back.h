// Judges whether a level of the refinement improved the mesh, and each of its parts. It uses data that the level did not see:
// camera pairs that were not used or, where there are none, small squares left out of the images.
//
// The mesh before and the mesh after the level have the same facets, unless it was cut anew between them
// (core/mesh/remesh.h): then read square of 4x4 pixels of a reference view for facet. The score of a facet is
//
//   e(mesh) = sum omega (1 - z) / sum omega
//
// over the windows that fall into it. Which windows do is frozen in a round: the level's first for the
// mesh before, its last for the mesh after. So both are scored on the same piece of surface. Facets that
// one of them leaves without windows do not count. The change is the mean of e(after) - e(before) over
// facets, weighted by the smaller sum of omega. Its standard error comes from the spread over 64 batches
// of neighbouring facets.
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
  int batches = 0;            // those with windows; the standard error is taken over them
  // The loss must exceed two standard errors: pairs that correlate on neither mesh say nothing. Few
  // batches say nothing either, because their spread cannot be measured.
  bool Known() const { return batches >= 8; }
  bool Worse() const { return Known() && after - before > 2 * standard_error; }
  bool Better() const { return Known() && before - after > 2 * standard_error; }
};

// Of the facets listed; neighbouring ones stand beside each other in the list.
HeldBackVerdict CompareScores(const std::vector<FacetScore>& before,
                              const std::vector<FacetScore>& after, const std::vector<int>& facets);
// Of all facets.
HeldBackVerdict CompareScores(const std::vector<FacetScore>& before,
                              const std::vector<FacetScore>& after);

// Of the cells that both have.
HeldBackVerdict CompareScores(const std::vector<CellScore>& before,
                              const std::vector<CellScore>& after);

// A connected component of the mesh is undone when it is worse by itself, however large the others are; all of
// the mesh when what is left is worse, or has no window to judge it by and was not placed by outlines (RoundContext::free). Of a mesh with other facets all is undone or
// nothing, and fewer facets may cost a twentieth of what the level before them gained.
class HeldBackJudge : public LevelJudge {
 public:
  // By `pairs`; where there are none, by squares, which `photometric` holds back then. It is a term of
  // the refinement and not owned.
  HeldBackJudge(std::vector<CameraPair> pairs, const PhotometricEnergy* photometric)
      : pairs_(std::move(pairs)), photometric_(photometric) {}

  const std::vector<CameraPair>& HeldBackPairs() const override { return pairs_; }
  void BeginLevel(const RoundContext& first, const TermRounds& terms, LevelFacets facets,
                  const nlohmann::json& report) override;
  LevelVerdict EndLevel(const RoundContext& last, const TermRounds& terms,
                        const TriangleMesh& after) override;

 private:
  // The verdict of all facets; of parts that are worse, the vertices. `outlines`: they may have placed what no window sees.
  HeldBackVerdict JudgeParts(const std::vector<FacetScore>& scores, const TriangleMesh& after,
                             bool outlines, std::vector<char>* undo) const;

  const std::vector<CameraPair> pairs_;
  const PhotometricEnergy* const photometric_;
  std::vector<FacetScore> before_;       // LevelFacets::kSame
  std::vector<CellScore> before_cells_;  // LevelFacets::kOther
  LevelFacets facets_ = LevelFacets::kSame;
  double allowed_ = 0;  // loss
  double seconds_ = 0;
};

}  // namespace burin
