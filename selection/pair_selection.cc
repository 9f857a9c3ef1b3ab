#include "selection/pair_selection.h"

#include <algorithm>
#include <functional>
#include <sstream>

#include "core/support/error.h"
#include "selection/pair_file.h"
#include "selection/ranking.h"
#include "selection/sparse_point_pairs.h"

namespace burin {
namespace {

constexpr size_t kCamerasNamedInError = 5;
// Of these, the best by estimate that the selection does not use, a view's held-back pair is chosen.
constexpr size_t kHeldBackCandidates = 8;
// What an estimate may be off by: least share of pairs.min_overlap that makes a pair a candidate by it.
constexpr double kEstimatedOverlap = 0.5;
constexpr double kMatchingParallaxDeg = 45;

template <typename Value>
Value RowMax(const std::vector<Value>& table, int n, int i) {
  return *std::max_element(table.begin() + static_cast<long>(i) * n,
                           table.begin() + static_cast<long>(i + 1) * n);
}

std::string RangeText(const PairsRecipe& recipe) {
  std::ostringstream range;
  range << recipe.min_parallax_deg << "-" << recipe.max_parallax_deg << " deg";
  return range.str();
}

// Why a method by sparse points found no partner for view i.
std::string PointReason(const Scene& scene, const PairsRecipe& recipe, int i) {
  const auto sees =
      std::count_if(scene.points.begin(), scene.points.end(), [i](const ScenePoint& point) {
        return std::binary_search(point.views.begin(), point.views.end(), i);
      });
  if (sees == 0) return "sees no sparse point";
  if (RowMax(CommonPointCounts(scene, 0, 180), static_cast<int>(scene.views.size()), i) == 0) {
    return "shares no sparse point with another view";
  }
  return "shares sparse points with other views, but none under a parallax of " + RangeText(recipe);
}

// Why a method by mesh found no partner for view i.
std::string MeshReason(const Scene& scene, const TriangleMesh& mesh, const PairsRecipe& recipe,
                       const PairSurvey& survey, int i) {
  const Camera& camera = scene.views[i].camera;
  const bool inside =
      std::any_of(mesh.vertices.begin(), mesh.vertices.end(), [&](const Eigen::Vector3d& vertex) {
        return camera.Depth(vertex) > 0 && camera.Contains(camera.Project(vertex));
      });
  double shared = 0;
  for (int j = 0; j < survey.view_count; ++j) shared = std::max(shared, survey.At(i, j).area);
  if (shared == 0 && survey.seen[i] == 0) {
    return inside ? "sees no facet of the mesh from the front"
                  : "no vertex of the mesh projects into it";
  }
  if (shared == 0) {
    return "no facet visible in it is visible in another view (facets seen from behind do not "
           "count)";
  }
  if (shared < recipe.min_overlap * survey.seen[i]) {
    std::ostringstream text;
    text << "shares at most " << 100 * shared / survey.seen[i]
         << " % of what it sees of the mesh with another view; pairs.min_overlap asks for "
         << 100 * recipe.min_overlap << " %";
    return text.str();
  }
  return "shares visible facets with other views, but none under a parallax of " +
         RangeText(recipe);
}

bool IsCandidate(const PairMeasure& measure, double seen, const PairsRecipe& recipe) {
  return measure.area > 0 && measure.area >= recipe.min_overlap * seen;
}

// Higher is better, 0 = not a candidate.
double Score(const PairMeasure& measure, double seen, const PairsRecipe& recipe) {
  if (!IsCandidate(measure, seen, recipe)) return 0;
  if (recipe.UsesEnergies()) return -EvaluatePair(measure, seen, recipe.bpv).total;
  return recipe.method == PairsMethod::kAll ? measure.area : measure.area_in_range;
}

std::vector<double> Scores(const PairSurvey& survey, const PairsRecipe& recipe) {
  const int n = survey.view_count;
  std::vector<double> scores(survey.measures.size(), 0);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      if (i == j) continue;
      scores[static_cast<size_t>(i) * n + j] = Score(survey.At(i, j), survey.seen[i], recipe);
    }
  }
  return scores;
}

// What held-back pairs are chosen by, whatever the others are.
PairsRecipe HeldBackRecipe() { return Resolve(PairsOptions()); }

// A pair and its reverse compare the same photographs on the same surface: the one cannot judge what was
// fitted to the other. (i, j) at i * view_count + j: 1 for pairs that are used in a direction.
std::vector<char> UsedInADirection(const std::vector<CameraPair>& pairs, int view_count) {
  std::vector<char> used(static_cast<size_t>(view_count) * view_count, 0);
  for (const auto& [i, j] : pairs) {
    used[static_cast<size_t>(i) * view_count + j] = 1;
    used[static_cast<size_t>(j) * view_count + i] = 1;
  }
  return used;
}

std::vector<char> References(const std::vector<CameraPair>& pairs, int view_count) {
  std::vector<char> is_reference(view_count, 0);
  for (const CameraPair& pair : pairs) is_reference[pair.reference] = 1;
  return is_reference;
}

// Of every reference the first kHeldBackCandidates of its list that `pairs` leave, or all that they leave where
// the list has none. `lists` are the estimate's.
std::vector<CameraPair> HeldBackCandidates(const PartnerLists& lists,
                                           const std::vector<CameraPair>& pairs) {
  const auto n = static_cast<int>(lists.size());
  const std::vector<char> used = UsedInADirection(pairs, n);
  const std::vector<char> is_reference = References(pairs, n);
  std::vector<CameraPair> candidates;
  const auto take = [&](int i, int j) {
    if (i == j || used[static_cast<size_t>(i) * n + j] != 0) return 0;
    candidates.push_back({i, j});
    return 1;
  };
  for (int i = 0; i < n; ++i) {
    if (is_reference[i] == 0) continue;
    size_t taken = 0;
    for (size_t k = 0; k < lists[i].size() && taken < kHeldBackCandidates; ++k) {
      taken += take(i, lists[i][k]);
    }
    for (int j = 0; taken == 0 && j < n; ++j) take(i, j);
  }
  return candidates;
}

std::vector<CameraPair> HeldBack(const PairSurvey& survey, const std::vector<CameraPair>& pairs) {
  const int n = survey.view_count;
  std::vector<double> scores = Scores(survey, HeldBackRecipe());
  const std::vector<char> used = UsedInADirection(pairs, n);
  const std::vector<char> is_reference = References(pairs, n);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const size_t at = static_cast<size_t>(i) * n + j;
      if (is_reference[i] == 0 || used[at] != 0) scores[at] = 0;
    }
  }
  return BestPartners(scores, n, 1);
}

std::vector<CameraPair> Matching(const PairSurvey& survey,
                                 const std::vector<CameraPair>& held_back) {
  const int n = survey.view_count;
  std::vector<double> scores = Scores(survey, HeldBackRecipe());
  const std::vector<char> held = UsedInADirection(held_back, n);
  for (size_t at = 0; at < scores.size(); ++at) {
    if (held[at] != 0 || survey.measures[at].parallax_deg > kMatchingParallaxDeg) scores[at] = 0;
  }
  return BestPartners(scores, n, kMatchingPartners);
}

// The best candidates of every view, by the estimate.
struct Candidates {
  PartnerLists own;        // by the method; none where the mesh does not choose
  PartnerLists held_back;  // by what held-back pairs are chosen by
};

Candidates EstimatedCandidates(const PairEstimate& estimate, const PairsRecipe& recipe) {
  std::vector<PairScore> scores;
  const auto add = [&scores](PairsRecipe by) {
    by.min_overlap *= kEstimatedOverlap;
    scores.emplace_back([by = std::move(by)](const PairMeasure& measure, double seen) {
      return Score(measure, seen, by);
    });
  };
  add(HeldBackRecipe());
  if (recipe.ByMesh()) add(recipe);
  std::vector<PartnerLists> lists = estimate.BestPartners(scores, recipe.candidates);
  Candidates candidates;
  candidates.held_back = std::move(lists[0]);
  if (recipe.ByMesh()) candidates.own = std::move(lists[1]);
  return candidates;
}

std::vector<CameraPair> PairsOf(const PartnerLists& lists) {
  std::vector<CameraPair> pairs;
  for (size_t i = 0; i < lists.size(); ++i) {
    for (const int j : lists[i]) pairs.push_back({static_cast<int>(i), j});
  }
  return pairs;
}

std::vector<CameraPair> BestByMesh(const PairSurvey& survey, const PairsRecipe& recipe) {
  const int n = survey.view_count;
  return BestPartners(Scores(survey, recipe), n,
                      recipe.method == PairsMethod::kAll ? n : recipe.per_camera);
}

// `surveyor` has measured the candidates.
void SelectByMesh(PairSurveyor* surveyor, PairSelection* selection) {
  const PairsRecipe& recipe = selection->recipe;
  const int n = surveyor->survey().view_count;
  selection->pairs = BestByMesh(surveyor->survey(), recipe);
  // An estimate leaves no camera without a partner that has one.
  const std::vector<char> has_partner = References(selection->pairs, n);
  std::vector<int> without;
  for (int i = 0; i < n; ++i) {
    if (has_partner[i] == 0) without.push_back(i);
  }
  if (surveyor->MeasureAllOf(without)) {
    selection->pairs = BestByMesh(surveyor->survey(), recipe);
  }
  selection->initial_pairs = selection->pairs;
  if (!recipe.UsesEnergies() || !recipe.improve_coverage) return;
  const PairSurvey& survey = surveyor->survey();
  SwapResult result = ImproveCoverage(selection->pairs, PairEnergyTable(survey, recipe), n,
                                      survey.facets, recipe.swaps);
  selection->pairs = std::move(result.pairs);
  selection->swaps = std::move(result.trials);
}

// A warning for each camera without a partner; an error where no camera has one. `reason` says why a view has
// none.
void WarnOfMissingPartners(const Scene& scene, const std::function<std::string(int)>& reason,
                           PairSelection* selection) {
  const auto n = static_cast<int>(scene.views.size());
  const std::vector<char> has_partner = References(selection->pairs, n);
  std::string error = "no camera pair: ";
  size_t named = 0;
  for (int i = 0; i < n; ++i) {
    if (has_partner[i] != 0) continue;
    if (named == kCamerasNamedInError && selection->pairs.empty()) break;
    const std::string line = scene.views[i].name + " " + reason(i);
    error += (named++ == 0 ? "" : "; ") + line;
    selection->warnings.push_back(line);
  }
  if (!selection->pairs.empty()) return;
  if (static_cast<size_t>(n) > named) {
    error += "; and " + std::to_string(static_cast<size_t>(n) - named) + " more";
  }
  throw InputError(error);
}

void CheckAnyViewSees(const Scene& scene, const PairSurvey& survey) {
  if (std::any_of(survey.seen.begin(), survey.seen.end(), [](double share) { return share > 0; })) {
    return;
  }
  const bool masked = std::any_of(scene.views.begin(), scene.views.end(),
                                  [](const View& view) { return !view.mask.empty(); });
  throw InputError("no camera pair: none of the " + std::to_string(scene.views.size()) +
                   " views sees the front of a facet of the mesh" +
                   (masked ? " where its mask is not zero" : ""));
}

}  // namespace

std::vector<double> PairEnergyTable(const PairSurvey& survey, const PairsRecipe& recipe) {
  const int n = survey.view_count;
  std::vector<double> energies(survey.measures.size(), 0);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const PairMeasure& measure = survey.At(i, j);
      if (i == j || !IsCandidate(measure, survey.seen[i], recipe)) continue;
      energies[static_cast<size_t>(i) * n + j] =
          EvaluatePair(measure, survey.seen[i], recipe.bpv).total;
    }
  }
  return energies;
}

PairSelection SelectPairs(const Scene& scene, const TriangleMesh& mesh, const PairsOptions& options,
                          PairSurvey* survey) {
  PairSelection selection;
  selection.recipe = Resolve(options);
  const PairsRecipe& recipe = selection.recipe;
  const auto n = static_cast<int>(scene.views.size());
  if (n < 2) {
    throw InputError("no camera pair: the scene has " +
                     (n == 0 ? std::string("no view") : "one view only, " + scene.views[0].name) +
                     "; a pair needs two");
  }
  if (recipe.method == PairsMethod::kFile) {
    selection.pairs = selection.initial_pairs = ReadPairFile(recipe.file, scene);
  } else if (recipe.UsesSparsePoints()) {
    if (scene.points.empty()) {
      throw InputError("pairs.method = " + NameOf(recipe.method) +
                       ": the scene has no sparse points; take tuned");
    }
    selection.pairs = selection.initial_pairs = SparsePointPairs(
        scene, recipe.per_camera, recipe.min_parallax_deg, recipe.max_parallax_deg);
    WarnOfMissingPartners(
        scene, [&](int i) { return PointReason(scene, recipe, i); }, &selection);
  }

  const bool measure_all = recipe.candidates == 0 || n - 1 <= recipe.candidates;
  PairSurveyor surveyor(scene, mesh, recipe.survey,
                        {recipe.ByMesh() || measure_all || survey != nullptr, !measure_all});
  if (recipe.ByMesh()) CheckAnyViewSees(scene, surveyor.survey());
  Candidates candidates;
  if (measure_all) {
    surveyor.MeasureAllOf(AllViews(n));
  } else {
    candidates = EstimatedCandidates(surveyor.TakeEstimate(), recipe);
    surveyor.Measure(PairsOf(candidates.own));
  }
  if (recipe.ByMesh()) {
    SelectByMesh(&surveyor, &selection);
    WarnOfMissingPartners(
        scene, [&](int i) { return MeshReason(scene, mesh, recipe, surveyor.survey(), i); },
        &selection);
  }
  if (!measure_all) {
    surveyor.Measure(HeldBackCandidates(candidates.held_back, selection.pairs));
  }
  selection.held_back = HeldBack(surveyor.survey(), selection.pairs);
  surveyor.Measure(selection.pairs);
  selection.matching = Matching(surveyor.survey(), selection.held_back);
  if (survey != nullptr) *survey = surveyor.Take();
  return selection;
}

}  // namespace burin
