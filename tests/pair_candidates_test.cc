// Which pairs are measured: those that an estimate finds best, without changing what is selected.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/support/error.h"
#include "selection/pair_file.h"
#include "selection/pair_selection.h"
#include "tests/test_scene.h"

namespace burin {
namespace {

void AddView(const Camera& camera, Scene* scene) {
  View& view = scene->views.emplace_back();
  view.name = "view" + std::to_string(scene->views.size() - 1);
  view.camera = camera;
}

Eigen::Vector3d OnArc(double degrees, double height = 0) {
  const double angle = degrees * M_PI / 180;
  return 5 * Eigen::Vector3d(std::sin(angle), height, std::cos(angle));
}

Camera CameraOnArc(double degrees, double height = 0) {
  return test::LookAt(OnArc(degrees, height), Eigen::Vector3d::Zero(), 100, 80, 120);
}

TriangleMesh Bumps() {
  TriangleMesh mesh;
  test::AppendGrid(&mesh, 24, 0, 0, 1.2,
                   [](double x, double y) { return 0.3 * std::sin(4 * x) * std::cos(3 * y); });
  return mesh;
}

// Two rows of views, unevenly spaced, over bumps that hide parts of each other.
Scene TwoRows(int views) {
  Scene scene;
  for (int i = 0; i < views; ++i) {
    const double place = static_cast<double>(i) / (views - 1);
    AddView(CameraOnArc(-60 + 120 * place * (0.5 + 0.5 * place), 0.2 * (i % 2)), &scene);
  }
  return scene;
}

PairsOptions WithCandidates(int candidates, PairsMethod method = PairsMethod::kTuned) {
  PairsOptions options;
  options.method = method;
  options.candidates = candidates;
  return options;
}

int64_t MeasuredPairs(const PairSurvey& survey) {
  return std::count_if(survey.measures.begin(), survey.measures.end(),
                       [](const PairMeasure& measure) { return measure.area > 0; });
}

TEST(PairCandidates, NoneOrEnoughOfThemMeasureAllPairs) {
  const Scene scene = TwoRows(12);
  const PairSurvey all = SurveyPairs(scene, Bumps(), SurveyOptions());
  for (const int candidates : {-1, 0, 11}) {
    PairSurvey survey;
    const PairSelection selection =
        SelectPairs(scene, Bumps(), WithCandidates(candidates), &survey);
    EXPECT_EQ(PairTermsCsv(scene, survey, selection), PairTermsCsv(scene, all, selection));
    EXPECT_EQ(MeasuredPairs(survey), 12 * 11);
  }
}

TEST(PairCandidates, SelectTheSamePairs) {
  const Scene scene = TwoRows(40);
  for (const PairsMethod method : {PairsMethod::kTuned, PairsMethod::kPaper,
                                   PairsMethod::kPaperStrict, PairsMethod::kMeshParallax}) {
    SCOPED_TRACE(NameOf(method));
    PairSurvey survey;
    const PairSelection all = SelectPairs(scene, Bumps(), WithCandidates(0, method), &survey);
    EXPECT_EQ(MeasuredPairs(survey), 40 * 39);
    const PairSelection some = SelectPairs(scene, Bumps(), WithCandidates(-1, method), &survey);
    EXPECT_EQ(some.pairs, all.pairs);
    EXPECT_EQ(some.held_back, all.held_back);
    EXPECT_EQ(some.swaps.size(), all.swaps.size());
    EXPECT_LE(MeasuredPairs(survey), 40 * (32 + 8));
  }
}

// Whatever the energy uses: near partners for windows that are matched, none that a held-back pair judges.
TEST(PairCandidates, PartnersForTracksAreNearAndNotHeldBack) {
  const Scene scene = TwoRows(12);
  const PairSelection selection = SelectPairs(scene, Bumps(), WithCandidates(0));
  const PairSurvey survey = SurveyPairs(scene, Bumps(), selection.recipe.survey);
  const std::vector<double> energies = PairEnergyTable(survey, Resolve(PairsOptions()));
  const auto is_held = [&](int i, int j) {
    return std::any_of(selection.held_back.begin(), selection.held_back.end(),
                       [&](const CameraPair& held) {
                         return held == CameraPair{i, j} || held == CameraPair{j, i};
                       });
  };
  const auto may_match = [&](int i, int j) {
    return energies[i * 12 + j] < 0 && survey.At(i, j).parallax_deg <= 45 && !is_held(i, j);
  };
  for (int i = 0; i < 12; ++i) {
    int possible = 0;
    int held = 0;
    for (int j = 0; j < 12; ++j) {
      possible += may_match(i, j) ? 1 : 0;
      held += is_held(i, j) ? 1 : 0;
    }
    EXPECT_GT(possible, 1) << i;
    EXPECT_GT(held, 0) << i;
    int chosen = 0;
    for (const CameraPair& pair : selection.matching) {
      if (pair.reference != i) continue;
      ++chosen;
      EXPECT_TRUE(may_match(i, pair.second)) << i << " " << pair.second;
    }
    EXPECT_EQ(chosen, std::min(possible, kMatchingPartners)) << i;
  }
  EXPECT_EQ(selection.ForTracks(), selection.matching);
  EXPECT_TRUE(PairSelection().ForTracks().empty());
}

// What the estimate counts of each partner, by hand.
TEST(PairCandidates, TheEstimateSeesMasksLidsAndBackSides) {
  TriangleMesh mesh;
  test::AppendGrid(&mesh, 8, 0, 0, 0.3, [](double, double) { return 0.0; });
  // View 2 is under a lid that no other view sees the front of.
  test::AppendGrid(&mesh, 1, 0.65, 0, 0.4, [](double, double) { return 2.0; });
  for (size_t f = mesh.faces.size() - 2; f < mesh.faces.size(); ++f) {
    std::swap(mesh.faces[f][1], mesh.faces[f][2]);
  }
  Scene scene;
  for (const double degrees : {0.0, -20.0, 14.0, 180.0, -30.0, -40.0}) {
    AddView(CameraOnArc(degrees), &scene);
  }
  scene.views[4].mask = cv::Mat(80, 100, CV_8UC1, cv::Scalar(0));
  PairSurveyor surveyor(scene, mesh, SurveyOptions(), {/*facets=*/false, /*points=*/true});
  const PairScore parallax = [](const PairMeasure& measure, double) {
    return measure.parallax_deg;
  };
  const PairScore area = [](const PairMeasure& measure, double seen) {
    return measure.area > 0.99 * seen ? measure.area : 0;
  };
  const PairEstimate estimate = surveyor.TakeEstimate();
  const std::vector<PartnerLists> lists = estimate.BestPartners({parallax, area}, 5);
  EXPECT_EQ(lists[0][0], (std::vector<int>{5, 1}));
  EXPECT_EQ(lists[1][0].size(), 2u);
  EXPECT_TRUE(lists[0][4].empty());
  EXPECT_EQ(estimate.BestPartners({parallax}, 1)[0][0], (std::vector<int>{5}));
}

// Views that share too little for an estimate to make them candidates are measured all the same, for the
// reason to be right.
TEST(PairCandidates, ACameraWithoutOneIsToldWhy) {
  TriangleMesh wide;
  test::AppendGrid(&wide, 20, 0, 0, 8, [](double, double) { return 0.0; });
  Scene scene;
  for (const double x : {-2.45, 2.45, -2.45}) {
    AddView(test::LookAt({x, 0, 5}, {x, 0, 0}, 200, 200, 200), &scene);
  }
  scene.views[2].mask = cv::Mat(200, 200, CV_8UC1, cv::Scalar(0));
  PairsOptions options = WithCandidates(1, PairsMethod::kPaper);
  options.per_camera = 1;
  std::string text;
  try {
    SelectPairs(scene, wide, options);
  } catch (const InputError& error) {
    text = error.what();
  }
  EXPECT_NE(text.find("view0 shares at most 2."), std::string::npos) << text;
  EXPECT_NE(text.find("view1 shares at most 2."), std::string::npos) << text;
}

class PairsFromFile : public testing::Test {
 protected:
  void SetUp() override {
    path_ = std::filesystem::path(testing::TempDir()) / "pair_candidates_test.json";
  }
  void TearDown() override { std::filesystem::remove(path_); }
  // Of a file with `pairs`.
  PairSelection Select(const Scene& scene, const std::vector<CameraPair>& pairs, int candidates,
                       PairSurvey* survey = nullptr) const {
    nlohmann::json json = {{"pairs", nlohmann::json::array()}};
    for (const auto& [i, j] : pairs) {
      json["pairs"].push_back(
          {{"reference", scene.views[i].name}, {"second", scene.views[j].name}});
    }
    std::ofstream(path_) << json;
    PairsOptions options = WithCandidates(candidates, PairsMethod::kFile);
    options.file = path_.string();
    return SelectPairs(scene, Bumps(), options, survey);
  }
  std::filesystem::path path_;
};

TEST_F(PairsFromFile, MeasureWhatIsHeldBack) {
  const Scene scene = TwoRows(40);
  const std::vector<CameraPair> pairs = SelectPairs(scene, Bumps(), WithCandidates(0)).pairs;
  const PairSelection all = Select(scene, pairs, 0);
  PairSurvey survey;
  const PairSelection some = Select(scene, pairs, -1, &survey);
  EXPECT_EQ(all.held_back.size(), 40u);
  EXPECT_EQ(some.held_back, all.held_back);
  EXPECT_EQ(some.pairs, pairs);
  // The candidates of the held-back pairs, and what the file has.
  EXPECT_LE(MeasuredPairs(survey), 40 * (8 + 4));
  for (const auto& [i, j] : pairs) EXPECT_GT(survey.At(i, j).area, 0);
}

// The best partners are used: others are held back.
TEST_F(PairsFromFile, WithMorePartnersThanCandidatesStillHoldBack) {
  const Scene scene = TwoRows(12);
  PairsOptions many;
  many.per_camera = 8;
  const std::vector<CameraPair> pairs = SelectPairs(scene, Bumps(), many).pairs;
  const PairSelection all = Select(scene, pairs, 0);
  EXPECT_FALSE(all.held_back.empty());
  EXPECT_EQ(Select(scene, pairs, 4).held_back, all.held_back);
}

}  // namespace
}  // namespace burin
