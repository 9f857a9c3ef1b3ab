#include "selection/pair_selection.h"

#include <algorithm>
#include <optional>
#include <sstream>

#include "core/support/error.h"
#include "selection/pair_file.h"
#include "selection/ranking.h"
#include "selection/sparse_point_pairs.h"

namespace burin {
namespace {

constexpr size_t kCamerasNamedInError = 5;

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

bool IsCandidate(const PairSurvey& survey, const PairsRecipe& recipe, int i, int j) {
  const double area = survey.At(i, j).area;
  return area > 0 && area >= recipe.min_overlap * survey.seen[i];
}

// Higher is better, 0 = not a candidate.
std::vector<double> Scores(const PairSurvey& survey, const PairsRecipe& recipe) {
  if (recipe.UsesEnergies()) {
    std::vector<double> scores = PairEnergyTable(survey, recipe);
    for (double& score : scores) score = -score;
    return scores;
  }
  std::vector<double> scores(survey.measures.size(), 0);
  for (int i = 0; i < survey.view_count; ++i) {
    for (int j = 0; j < survey.view_count; ++j) {
      if (!IsCandidate(survey, recipe, i, j)) continue;
      const PairMeasure& measure = survey.At(i, j);
      scores[static_cast<size_t>(i) * survey.view_count + j] =
          recipe.method == PairsMethod::kAll ? measure.area : measure.area_in_range;
    }
  }
  return scores;
}

void SelectByMesh(const PairSurvey& survey, PairSelection* selection) {
  const PairsRecipe& recipe = selection->recipe;
  const int n = survey.view_count;
  selection->pairs = BestPartners(Scores(survey, recipe), n,
                                  recipe.method == PairsMethod::kAll ? n : recipe.per_camera);
  selection->initial_pairs = selection->pairs;
  if (!recipe.UsesEnergies() || !recipe.improve_coverage) return;
  SwapResult result = ImproveCoverage(selection->pairs, PairEnergyTable(survey, recipe), n,
                                      survey.facets, recipe.swaps);
  selection->pairs = std::move(result.pairs);
  selection->swaps = std::move(result.trials);
}

// A pair and its reverse compare the same photographs on the same surface: the one cannot judge what was
// fitted to the other.
std::vector<CameraPair> HeldBack(const PairSurvey& survey, const std::vector<CameraPair>& pairs) {
  const int n = survey.view_count;
  const std::vector<double> energies = PairEnergyTable(survey, Resolve(PairsOptions()));
  std::vector<double> scores(energies.size(), 0);
  for (const CameraPair& pair : pairs) {
    const size_t row = static_cast<size_t>(pair.reference) * n;
    for (int j = 0; j < n; ++j) scores[row + j] = -energies[row + j];
  }
  for (const CameraPair& pair : pairs) {
    scores[static_cast<size_t>(pair.reference) * n + pair.second] = 0;
    scores[static_cast<size_t>(pair.second) * n + pair.reference] = 0;
  }
  return BestPartners(scores, n, 1);
}

}  // namespace

std::vector<double> PairEnergyTable(const PairSurvey& survey, const PairsRecipe& recipe) {
  const int n = survey.view_count;
  std::vector<double> energies(survey.measures.size(), 0);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      if (i == j || !IsCandidate(survey, recipe, i, j)) continue;
      energies[static_cast<size_t>(i) * n + j] =
          EvaluatePair(survey.At(i, j), survey.seen[i], recipe.bpv).total;
    }
  }
  return energies;
}

PairSelection SelectPairs(const Scene& scene, const TriangleMesh& mesh, const PairsOptions& options,
                          const PairSurvey* survey) {
  PairSelection selection;
  selection.recipe = Resolve(options);
  const PairsRecipe& recipe = selection.recipe;
  const auto n = static_cast<int>(scene.views.size());
  if (n < 2) {
    throw InputError("no camera pair: the scene has " +
                     (n == 0 ? std::string("no view") : "one view only, " + scene.views[0].name) +
                     "; a pair needs two");
  }
  std::optional<PairSurvey> own_survey;
  if (recipe.method == PairsMethod::kFile) {
    selection.pairs = selection.initial_pairs = ReadPairFile(recipe.file, scene);
    selection.held_back = HeldBack(SurveyPairs(scene, mesh, recipe.survey), selection.pairs);
    return selection;
  }
  if (recipe.UsesSparsePoints()) {
    if (scene.points.empty()) {
      throw InputError("pairs.method = " + NameOf(recipe.method) +
                       ": the scene has no sparse points; take tuned");
    }
    selection.pairs = SparsePointPairs(scene, recipe.per_camera, recipe.min_parallax_deg,
                                       recipe.max_parallax_deg);
    selection.initial_pairs = selection.pairs;
  } else {
    if (survey == nullptr) survey = &own_survey.emplace(SurveyPairs(scene, mesh, recipe.survey));
    if (std::all_of(survey->seen.begin(), survey->seen.end(),
                    [](double share) { return share == 0; })) {
      const bool masked = std::any_of(scene.views.begin(), scene.views.end(),
                                      [](const View& view) { return !view.mask.empty(); });
      throw InputError("no camera pair: none of the " + std::to_string(n) +
                       " views sees the front of a facet of the mesh" +
                       (masked ? " where its mask is not zero" : ""));
    }
    SelectByMesh(*survey, &selection);
  }
  std::string error = "no camera pair: ";
  size_t named = 0;
  for (int i = 0; i < n; ++i) {
    const bool has_partner =
        std::any_of(selection.pairs.begin(), selection.pairs.end(),
                    [i](const CameraPair& pair) { return pair.reference == i; });
    if (has_partner) continue;
    if (selection.warnings.size() < kCamerasNamedInError || !selection.pairs.empty()) {
      const std::string line =
          scene.views[i].name + " " +
          (recipe.UsesSparsePoints() ? PointReason(scene, recipe, i)
                                     : MeshReason(scene, mesh, recipe, *survey, i));
      error += (named++ == 0 ? "" : "; ") + line;
      selection.warnings.push_back(line);
    }
  }
  if (selection.pairs.empty()) {
    if (static_cast<size_t>(n) > named) {
      error += "; and " + std::to_string(static_cast<size_t>(n) - named) + " more";
    }
    throw InputError(error);
  }
  if (survey == nullptr) survey = &own_survey.emplace(SurveyPairs(scene, mesh, recipe.survey));
  selection.held_back = HeldBack(*survey, selection.pairs);
  return selection;
}

}  // namespace burin
