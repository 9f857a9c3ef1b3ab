#include "selection/pair_file.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/support/error.h"
#include "core/support/json_file.h"
#include "core/support/spelling.h"

namespace burin {
namespace {

constexpr const char* kFormat = "burin pairs 1";

int ViewNamed(const nlohmann::json& entry, const char* key, const std::map<std::string, int>& views,
              const std::filesystem::path& path, const std::string& element) {
  if (!entry.is_object() || !entry.contains(key) || !entry[key].is_string()) {
    throw InputError(path, element + "." + key + ": must be the name of a view");
  }
  const std::string name = entry[key].get<std::string>();
  const auto found = views.find(SpellingKey(name));
  if (found == views.end()) {
    throw InputError(path, element + "." + key + " = '" + name + "': the scene has no such view");
  }
  return found->second;
}

nlohmann::ordered_json CoverageJson(const PairSurvey& survey, const PairsRecipe& recipe,
                                    const std::vector<CameraPair>& pairs) {
  Coverage coverage(survey.facets, survey.view_count, !recipe.swaps.printed_facets);
  for (const CameraPair& pair : pairs) coverage.Add(pair);
  return {{"mean", coverage.Mean()},
          {"stddev", coverage.StdDev()},
          {"covered_share", coverage.CoveredShare()}};
}

double TotalEnergy(const PairSurvey& survey, const PairsRecipe& recipe,
                   const std::vector<CameraPair>& pairs) {
  double sum = 0;
  for (const auto& [i, j] : pairs) {
    sum += EvaluatePair(survey.At(i, j), survey.seen[i], recipe.bpv).total;
  }
  return sum;
}

double OverlapShare(const PairSurvey& survey, int i, int j) {
  return survey.seen[i] > 0 ? survey.At(i, j).area / survey.seen[i] : 0;
}

}  // namespace

std::vector<CameraPair> ReadPairFile(const std::filesystem::path& path, const Scene& scene) {
  const nlohmann::json json = ReadJsonFile(path);
  if (!json.is_object() || !json.contains("pairs") || !json["pairs"].is_array()) {
    throw InputError(path, "pairs: must be a list of {\"reference\": view, \"second\": view}");
  }
  if (json.contains("format") && json["format"] != kFormat) {
    throw InputError(path, "format: must be \"" + std::string(kFormat) + "\"");
  }
  std::map<std::string, int> views;
  for (size_t i = 0; i < scene.views.size(); ++i) {
    views[SpellingKey(scene.views[i].name)] = static_cast<int>(i);
  }
  std::vector<CameraPair> pairs;
  for (const nlohmann::json& entry : json["pairs"]) {
    const std::string element = "pairs[" + std::to_string(pairs.size()) + "]";
    const int reference = ViewNamed(entry, "reference", views, path, element);
    const int second = ViewNamed(entry, "second", views, path, element);
    pairs.push_back({reference, second});
  }
  if (pairs.empty()) throw InputError(path, "pairs: is empty");
  if (const std::string fault = PairsFault(pairs, scene); !fault.empty()) {
    throw InputError(path, fault);
  }
  return pairs;
}

nlohmann::ordered_json PairsJson(const Scene& scene, const PairSurvey& survey,
                                 const PairSelection& selection) {
  const PairsRecipe& recipe = selection.recipe;
  const auto name = [&scene](int i) { return InUtf8(scene.views[i].name); };
  nlohmann::ordered_json json;
  json["format"] = kFormat;
  json["method"] = NameOf(recipe.method);
  json["without_partner"] = selection.warnings;
  json["pairs"] = nlohmann::ordered_json::array();
  for (const auto& [i, j] : selection.pairs) {
    const PairMeasure& measure = survey.At(i, j);
    const PairEnergies energies = EvaluatePair(measure, survey.seen[i], recipe.bpv);
    json["pairs"].push_back(
        {{"reference", name(i)},
         {"second", name(j)},
         {"E_bpv", energies.total},
         {"E_p", energies.parallax},
         {"E_o", energies.overlap},
         {"E_s", energies.symmetry},
         {"E_r", energies.resolution},
         {"parallax_deg", measure.parallax_deg},
         {"overlap", OverlapShare(survey, i, j)},
         {"overlap_of_image", measure.area},
         {"symmetry_deg", SymmetryDeg(measure, recipe.bpv)},
         {"resolution",
          recipe.bpv.printed_resolution ? measure.resolution_printed : measure.resolution}});
  }
  json["coverage"] = {{"facets", recipe.swaps.printed_facets ? "all" : "seen by two views"},
                      {"before", CoverageJson(survey, recipe, selection.initial_pairs)},
                      {"after", CoverageJson(survey, recipe, selection.pairs)}};
  json["energy"] = {{"before", TotalEnergy(survey, recipe, selection.initial_pairs)},
                    {"after", TotalEnergy(survey, recipe, selection.pairs)}};
  json["swaps"] = nlohmann::ordered_json::array();
  for (const SwapTrial& trial : selection.swaps) {
    json["swaps"].push_back({{"sweep", trial.sweep},
                             {"reference", name(trial.reference)},
                             {"from", name(trial.from)},
                             {"to", name(trial.to)},
                             {"accepted", trial.accepted},
                             {"reason", trial.reason},
                             {"mean", trial.mean},
                             {"stddev", trial.stddev},
                             {"energy", trial.energy}});
  }
  return json;
}

std::string PairTermsCsv(const Scene& scene, const PairSurvey& survey,
                         const PairSelection& selection) {
  std::ostringstream csv;
  csv.precision(6);
  csv << "reference,second,selected,area,overlap,parallax_deg,symmetry_deg,resolution,E_p,E_o,E_s,"
         "E_r,E_bpv\n";
  const BpvOptions& bpv = selection.recipe.bpv;
  for (int i = 0; i < survey.view_count; ++i) {
    for (int j = 0; j < survey.view_count; ++j) {
      const PairMeasure& measure = survey.At(i, j);
      if (measure.area <= 0) continue;
      const PairEnergies energies = EvaluatePair(measure, survey.seen[i], bpv);
      const bool selected = std::find(selection.pairs.begin(), selection.pairs.end(),
                                      CameraPair{i, j}) != selection.pairs.end();
      csv << scene.views[i].name << ',' << scene.views[j].name << ',' << (selected ? 1 : 0) << ','
          << measure.area << ',' << OverlapShare(survey, i, j) << ',' << measure.parallax_deg << ','
          << SymmetryDeg(measure, bpv) << ','
          << (bpv.printed_resolution ? measure.resolution_printed : measure.resolution) << ','
          << energies.parallax << ',' << energies.overlap << ',' << energies.symmetry << ','
          << energies.resolution << ',' << energies.total << '\n';
    }
  }
  return csv.str();
}

}  // namespace burin
