// The discrete step before solving: which directed camera pairs enter the photometric energy.
// The methods and their options are those of pairs_options.h; docs/camera_pairs.md compares them.
#pragma once

#include <string>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/pairs.h"
#include "core/scene/scene.h"
#include "selection/coverage.h"
#include "selection/pair_survey.h"
#include "selection/pairs_options.h"

namespace burin {

struct PairSelection {
  PairsRecipe recipe;                     // how they were chosen
  std::vector<CameraPair> pairs;          // those of a camera together, best first
  std::vector<CameraPair> initial_pairs;  // before Algorithm 1; the same for methods without it
  std::vector<SwapTrial> swaps;           // what Algorithm 1 tried
  // For each camera with a partner the best pair that is used in neither direction, where there is one:
  // to judge the refinement by.
  std::vector<CameraPair> held_back;
  // For tracks through the mesh (core/cameras/mesh_tracks.h): for each view up to kMatchingPartners under a mean parallax of
  // at most 45 degrees, best first, of pairs that are held back in no direction. What the energy is best
  // served by may be too far apart to be matched.
  std::vector<CameraPair> matching;
  // `pairs` where nothing is measured.
  std::vector<CameraPair> ForTracks() const { return matching.empty() ? pairs : matching; }
  std::vector<std::string> warnings;  // a line for each camera without a partner, with the reason
};

// E_BPV of every pair, (i, j) at i * view_count + j; 0 for pairs that share less than
// `recipe.min_overlap` of what view i sees.
std::vector<double> PairEnergyTable(const PairSurvey& survey, const PairsRecipe& recipe);

// Throws InputError when there are fewer than two views, when no camera gets a partner (saying for
// each camera which test failed), and for a pairs file that does not fit the scene. `survey` gets what was
// measured on the way, at least for the selected pairs, and the facets that views see.
PairSelection SelectPairs(const Scene& scene, const TriangleMesh& mesh, const PairsOptions& options,
                          PairSurvey* survey = nullptr);

}  // namespace burin
