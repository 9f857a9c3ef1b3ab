// pairs.json: writes the pairs of a selection with the reasons for them, and reads pairs chosen elsewhere or
// by hand.
//
//   {"format": "burin pairs 1", "pairs": [{"reference": "a.jpg", "second": "b.jpg", ...}, ...], ...}
//
// Readers need "pairs" with view names; everything else is for people and scripts.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "selection/pair_selection.h"

namespace burin {

// Pairs in the order of the file. Throws InputError (file, element, reason) for what is not JSON or
// lacks "pairs", for names no view has, a view paired with itself, a pair that appears twice, and
// for no pair at all.
std::vector<CameraPair> ReadPairFile(const std::filesystem::path& path, const Scene& scene);

// The pairs with every term, coverage before and after Algorithm 1, and what it tried and why.
nlohmann::ordered_json PairsJson(const Scene& scene, const PairSurvey& survey,
                                 const PairSelection& selection);

// Every measured pair that shares surface, a line each, as CSV:
// reference,second,selected,area,overlap,parallax_deg,symmetry_deg,resolution,E_p,E_o,E_s,E_r,E_bpv
std::string PairTermsCsv(const Scene& scene, const PairSurvey& survey,
                         const PairSelection& selection);

}  // namespace burin
