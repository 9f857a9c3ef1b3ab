// Pair selection on configurations whose answer is known.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/support/error.h"
#include "core/support/parallel.h"
#include "selection/pair_file.h"
#include "selection/pair_selection.h"
#include "selection/sparse_point_pairs.h"
#include "tests/test_scene.h"

namespace burin {
namespace {

// Cameras at distance 5 from the origin, `degrees` from the z axis in the x-z plane.
Scene ArcScene(const std::vector<double>& degrees) {
  Scene scene;
  for (size_t i = 0; i < degrees.size(); ++i) {
    const double angle = degrees[i] * M_PI / 180;
    View view;
    view.name = "view" + std::to_string(i);
    view.camera = test::LookAt(5 * Eigen::Vector3d(std::sin(angle), 0, std::cos(angle)),
                               Eigen::Vector3d::Zero(), 100, 100, 100);
    scene.views.push_back(view);
  }
  return scene;
}

TriangleMesh Plane() {
  TriangleMesh mesh;
  test::AppendGrid(&mesh, 8, 0, 0, 0.1, [](double, double) { return 0.0; });
  return mesh;
}

PairsOptions Method(PairsMethod method, int per_camera = 4) {
  PairsOptions options;
  options.method = method;
  options.per_camera = per_camera;
  return options;
}

int PartnerOf(const PairSelection& selection, int view) {
  for (const CameraPair& pair : selection.pairs) {
    if (pair.reference == view) return pair.second;
  }
  return -1;
}

TEST(SparsePointPairs, CountsOnlyPointsInTheParallaxRange) {
  Scene scene = ArcScene({0, 10, 30, 100});
  scene.points = {{Eigen::Vector3d(0.01, 0, 0), {0, 1, 2, 3}},
                  {Eigen::Vector3d(0, 0.01, 0), {0, 2}},
                  {Eigen::Vector3d(0, 0, 0.01), {1, 3}}};
  const std::vector<int> counts = CommonPointCounts(scene, 20 - 1e-6, 60);
  EXPECT_EQ(counts[0 * 4 + 1], 0);  // 10 degrees
  EXPECT_EQ(counts[0 * 4 + 2], 2);  // 30 degrees, two points
  EXPECT_EQ(counts[2 * 4 + 0], 2);
  EXPECT_EQ(counts[1 * 4 + 3], 0);  // 90 degrees
  const auto pairs = SparsePointPairs(scene, 1, 20 - 1, 60);
  ASSERT_EQ(pairs.size(), 3u);
  EXPECT_TRUE((pairs[0] == CameraPair{0, 2}));
  EXPECT_TRUE((pairs[1] == CameraPair{1, 2}));
  EXPECT_TRUE((pairs[2] == CameraPair{2, 0}));
}

TEST(PairSelection, TunedNeedsNoPointsAndTakesAboutTwentyDegrees) {
  const PairSelection selection =
      SelectPairs(ArcScene({0, 5, 21, 50}), Plane(), Method(PairsMethod::kTuned, 1));
  EXPECT_EQ(PartnerOf(selection, 0), 2);
  EXPECT_EQ(PartnerOf(selection, 3), 2);
}

std::string ErrorOf(const Scene& scene, const TriangleMesh& mesh, const PairsOptions& options) {
  try {
    SelectPairs(scene, mesh, options);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(PairSelection, ZeroPairsNamesCameraAndTest) {
  Scene scene = ArcScene({0, 3});
  PairsOptions options;
  options.method = PairsMethod::kMeshParallax;
  EXPECT_EQ(ErrorOf(scene, Plane(), options),
            "no camera pair: view0 shares visible facets with other views, but none under a "
            "parallax of 8-45 deg; view1 shares visible facets with other views, but none under a "
            "parallax of 8-45 deg");
  options.method = PairsMethod::kVu;
  EXPECT_EQ(ErrorOf(scene, Plane(), options),
            "pairs.method = vu: the scene has no sparse points; take tuned");
  scene.points = {{Eigen::Vector3d::Zero(), {0, 1}}};
  EXPECT_NE(ErrorOf(scene, Plane(), options).find("none under a parallax of 20-60 deg"),
            std::string::npos);
}

TEST(PairSelection, ACameraWithoutPartnerIsAWarning) {
  Scene scene = ArcScene({0, 30, 180});
  const PairSelection selection = SelectPairs(scene, Plane(), PairsOptions());
  EXPECT_EQ(selection.pairs.size(), 2u);
  ASSERT_EQ(selection.warnings.size(), 1u);
  EXPECT_NE(selection.warnings[0].find("view2"), std::string::npos);
}

// Views 0 and 1 stand best to each other but have masks that leave nothing in common; so do 2 and 3.
TEST(PairSelection, PairsShareWhatMasksLeave) {
  TriangleMesh mesh;
  test::AppendGrid(&mesh, 16, 0, 0, 1.5, [](double, double) { return 0.0; });
  Scene scene = ArcScene({0, 20, 29, -9});
  EXPECT_EQ(PartnerOf(SelectPairs(scene, mesh, Method(PairsMethod::kTuned, 1)), 0), 1);
  for (const int i : {0, 1, 2, 3}) {
    View& view = scene.views[i];
    view.mask = cv::Mat(100, 100, CV_8UC1, cv::Scalar(0));
    view.mask.colRange(i % 2 == 0 ? 0 : 52, i % 2 == 0 ? 48 : 100) = 1;
  }
  for (const PairsMethod method :
       {PairsMethod::kTuned, PairsMethod::kPaper, PairsMethod::kMeshParallax, PairsMethod::kAll}) {
    const PairSelection selection = SelectPairs(scene, mesh, Method(method, 2));
    EXPECT_FALSE(selection.pairs.empty()) << NameOf(method);
    for (const CameraPair& pair : selection.pairs) {
      EXPECT_EQ(pair.reference % 2, pair.second % 2) << NameOf(method);
    }
  }
  // A camera that is left without a partner is named.
  scene.views[3].mask = cv::Mat(100, 100, CV_8UC1, cv::Scalar(0));
  EXPECT_EQ(SelectPairs(scene, mesh, PairsOptions()).warnings.size(), 2u);
}

// View 0 stands at -30 degrees; view 1 beside it, view 2 across the normal, view 3 across and far
// away. All see the whole plane.
Scene SymmetryScene() {
  Scene scene = ArcScene({-30, -18, 30, 31});
  scene.views[3].camera =
      test::LookAt(2.2 * scene.views[3].camera.Center(), Eigen::Vector3d::Zero(), 100, 100, 100);
  return scene;
}

TEST(PairSelection, PaperTakesTheSymmetricPartnerOfEqualResolution) {
  EXPECT_EQ(PartnerOf(SelectPairs(SymmetryScene(), Plane(), Method(PairsMethod::kPaper, 1)), 0), 2);
  PairsOptions only_overlap = Method(PairsMethod::kPaper, 1);
  only_overlap.terms = "O";  // all the same: the first
  EXPECT_EQ(PartnerOf(SelectPairs(SymmetryScene(), Plane(), only_overlap), 0), 1);
}

// Without the resolution term (or with the printed one, which is inert) the far camera at the
// better angle wins.
TEST(PairSelection, ThePrintedResolutionTermDoesNotSeeDistance) {
  Scene scene = SymmetryScene();
  scene.views[2].camera =
      test::LookAt(ArcScene({10}).views[0].camera.Center(), Eigen::Vector3d::Zero(), 100, 100, 100);
  PairsOptions options = Method(PairsMethod::kPaper, 1);
  options.terms = "OSPR";
  EXPECT_EQ(PartnerOf(SelectPairs(scene, Plane(), options), 0), 2);
  options.resolution_term = PaperReading::kPrinted;
  EXPECT_EQ(PartnerOf(SelectPairs(scene, Plane(), options), 0), 3);
}

TEST(PairSelection, PerCameraGivesThatManyPartners) {
  const Scene scene = ArcScene({-40, -30, -20, -10, 0, 10, 20, 30, 40});
  for (const int partners : {1, 2, 4, 8}) {
    for (const PairsMethod method : {PairsMethod::kPaper, PairsMethod::kPaperStrict}) {
      EXPECT_EQ(SelectPairs(scene, Plane(), Method(method, partners)).pairs.size(), 9U * partners);
    }
  }
  EXPECT_EQ(SelectPairs(scene, Plane(), Method(PairsMethod::kAll)).pairs.size(), 72U);
}

// The reverse of a used pair has been fitted to the same photographs on the same surface.
TEST(PairSelection, APairIsHeldBackWhenNeitherDirectionIsUsed) {
  const Scene scene = ArcScene({0, 9, 16, 30, 52, 60, 80});
  const TriangleMesh mesh = Plane();
  const auto n = static_cast<int>(scene.views.size());
  for (int per_camera = 1; per_camera < n; ++per_camera) {
    SCOPED_TRACE(per_camera);
    const PairSelection selection =
        SelectPairs(scene, mesh, Method(PairsMethod::kTuned, per_camera));
    const auto used = [&](int i, int j) {
      return std::any_of(selection.pairs.begin(), selection.pairs.end(),
                         [&](const CameraPair& pair) {
                           return pair == CameraPair{i, j};
                         });
    };
    std::vector<int> held_by(n, 0);
    for (const CameraPair& pair : selection.held_back) {
      EXPECT_FALSE(used(pair.reference, pair.second)) << pair.reference << " " << pair.second;
      EXPECT_FALSE(used(pair.second, pair.reference)) << pair.reference << " " << pair.second;
      ++held_by[pair.reference];
    }
    const std::vector<double> energies =
        PairEnergyTable(SurveyPairs(scene, mesh, selection.recipe.survey), Resolve(PairsOptions()));
    for (int i = 0; i < n; ++i) {
      bool has = false;
      for (int j = 0; j < n; ++j) has |= energies[i * n + j] < 0 && !used(i, j) && !used(j, i);
      EXPECT_EQ(held_by[i], has ? 1 : 0) << i;
    }
  }
  EXPECT_TRUE(SelectPairs(scene, mesh, Method(PairsMethod::kAll)).held_back.empty());
}

TEST(PairSelection, PaperStrictLeavesTheInitialPairs) {
  const PairSelection selection =
      SelectPairs(ArcScene({-40, -10, 0, 30, 60}), Plane(), Method(PairsMethod::kPaperStrict, 1));
  EXPECT_EQ(selection.pairs, selection.initial_pairs);
  EXPECT_TRUE(selection.swaps.empty());
}

TEST(PairSelection, TolaCountsFrom10To30Degrees) {
  Scene scene = ArcScene({0, 25, 50});
  scene.points = {{Eigen::Vector3d::Zero(), {0, 1, 2}}};
  EXPECT_EQ(SelectPairs(scene, Plane(), Method(PairsMethod::kTola, 2)).pairs.size(), 4U);
  EXPECT_EQ(SelectPairs(scene, Plane(), Method(PairsMethod::kVu, 2)).pairs.size(), 6U);
}

TEST(PairSelection, TheSameForAnyNumberOfThreads) {
  Scene scene;
  for (const LevelView& level : test::RandomViews(160, 120)) {
    View view;
    view.name = "view" + std::to_string(scene.views.size());
    view.camera = level.camera;
    scene.views.push_back(view);
  }
  for (const int candidates : {0, 1}) {
    PairsOptions options = Method(PairsMethod::kPaper, 1);
    options.candidates = candidates;
    std::string before;
    for (const int threads : {1, 2, 4}) {
      const ThreadScope scope(threads);
      PairSurvey survey;
      const PairSelection selection = SelectPairs(scene, test::OccluderMesh(), options, &survey);
      const std::string json = PairsJson(scene, survey, selection).dump();
      EXPECT_TRUE(before.empty() || json == before) << threads << " " << candidates;
      before = json;
    }
  }
}

TEST(PairSelection, MeshMethodsNameTheFailingTest) {
  EXPECT_EQ(ErrorOf(ArcScene({0}), Plane(), Method(PairsMethod::kPaper)),
            "no camera pair: the scene has one view only, view0; a pair needs two");
  TriangleMesh away = Plane();
  for (Eigen::Vector3d& vertex : away.vertices) vertex.x() += 1000;
  EXPECT_EQ(ErrorOf(ArcScene({0, 30}), away, Method(PairsMethod::kPaper)),
            "no camera pair: none of the 2 views sees the front of a facet of the mesh");
  Scene masked = ArcScene({0, 30});
  for (View& view : masked.views) {
    view.mask = cv::Mat1b(view.camera.height, view.camera.width, uchar{0});
  }
  EXPECT_EQ(ErrorOf(masked, Plane(), Method(PairsMethod::kPaper)),
            "no camera pair: none of the 2 views sees the front of a facet of the mesh where its "
            "mask is not zero");
  // A wide plane of which the two views see ends that hardly meet.
  TriangleMesh wide;
  test::AppendGrid(&wide, 20, 0, 0, 8, [](double, double) { return 0.0; });
  Scene scene;
  for (const double x : {-2.4, 2.4}) {
    View& view = scene.views.emplace_back();
    view.name = x < 0 ? "left" : "right";
    view.camera = test::LookAt({x, 0, 5}, {x, 0, 0}, 200, 200, 200);
  }
  const std::string error = ErrorOf(scene, wide, Method(PairsMethod::kPaper));
  EXPECT_NE(error.find("left shares at most 3."), std::string::npos) << error;
  EXPECT_NE(error.find("pairs.min_overlap asks for 5 %"), std::string::npos) << error;
  PairsOptions lenient = Method(PairsMethod::kPaper);
  lenient.min_overlap = 0.01;
  EXPECT_EQ(SelectPairs(scene, wide, lenient).pairs.size(), 2U);
}

TEST(PairsOptions, WhatDoesNotFitIsAnInputError) {
  const auto error_of = [](const PairsOptions& options) -> std::string {
    try {
      options.Check();
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  PairsOptions options = Method(PairsMethod::kPaper);
  EXPECT_EQ(error_of(options), "");
  options.terms = "OX";
  EXPECT_EQ(error_of(options),
            "pairs.terms = OX: must be letters of O, S, P, R, C, each at most once");
  options.terms = "OO";
  EXPECT_NE(error_of(options), "");
  options.terms = "C";
  EXPECT_EQ(error_of(options), "pairs.terms = C: needs one of O, S, P, R");
  EXPECT_EQ(error_of(Method(PairsMethod::kFile)),
            "pairs.file: must name a file for pairs.method = file");
  options = Method(PairsMethod::kPaper);
  options.file = "pairs.json";
  EXPECT_EQ(error_of(options), "pairs.file: is read by pairs.method = file only, not by paper");
}

// As many candidates as partners wanted, whatever is given.
TEST(PairsOptions, CandidatesFollowThePartnersOfACamera) {
  for (const PairsMethod method : {PairsMethod::kTuned, PairsMethod::kPaper, PairsMethod::kVu}) {
    for (const int per_camera : {1, 4, 5, 40, 1000}) {
      PairsOptions options = Method(method, per_camera);
      EXPECT_EQ(Resolve(options).candidates, std::max(32, 8 * per_camera));
      options.candidates = 1;
      EXPECT_EQ(Resolve(options).candidates, per_camera);
      options.candidates = 1001;
      EXPECT_EQ(Resolve(options).candidates, 1001);
      options.candidates = 0;
      EXPECT_EQ(Resolve(options).candidates, 0);
    }
  }
  EXPECT_EQ(Resolve(Method(PairsMethod::kAll)).candidates, 0);
}

class PairFile : public testing::Test {
 protected:
  void SetUp() override {
    path_ = std::filesystem::path(testing::TempDir()) /
            (std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + ".json");
  }
  void TearDown() override { std::filesystem::remove(path_); }
  void Write(const std::string& text) const { std::ofstream(path_) << text; }
  std::string Error() const {
    PairsOptions options = Method(PairsMethod::kFile);
    options.file = path_.string();
    const std::string error = ErrorOf(ArcScene({0, 30, 60}), Plane(), options);
    return error.substr(std::min(error.size(), path_.string().size()));
  }
  std::filesystem::path path_;
};

TEST_F(PairFile, ReadsBackWhatSelectWrites) {
  const Scene scene = ArcScene({0, 30, 60});
  PairSurvey survey;
  const PairSelection selection =
      SelectPairs(scene, Plane(), Method(PairsMethod::kPaper, 2), &survey);
  Write(PairsJson(scene, survey, selection).dump(2));
  EXPECT_EQ(ReadPairFile(path_, scene), selection.pairs);
  PairsOptions options = Method(PairsMethod::kFile);
  options.file = path_.string();
  EXPECT_EQ(SelectPairs(scene, Plane(), options).pairs, selection.pairs);
}

TEST_F(PairFile, HandWrittenPairsNeedOnlyNames) {
  Write(R"({"pairs": [{"reference": "view2", "second": "view0"}]})");
  EXPECT_EQ(ReadPairFile(path_, ArcScene({0, 30, 60})), (std::vector<CameraPair>{{2, 0}}));
}

TEST_F(PairFile, FaultsNameFileElementAndReason) {
  EXPECT_NE(Error(), "");  // missing
  Write("{\"pairs\": [");
  EXPECT_EQ(Error(), ": byte 12: not valid JSON");
  Write("{\"pairs\": 1e999}");
  EXPECT_EQ(Error(), ": has a number too large for a double");
  Write("[]");
  EXPECT_EQ(Error(), R"(: pairs: must be a list of {"reference": view, "second": view})");
  Write(R"({"format": "other", "pairs": []})");
  EXPECT_EQ(Error(), R"(: format: must be "burin pairs 1")");
  Write(R"({"pairs": []})");
  EXPECT_EQ(Error(), ": pairs: is empty");
  Write(R"({"pairs": [{"reference": "view0"}]})");
  EXPECT_EQ(Error(), ": pairs[0].second: must be the name of a view");
  Write(R"({"pairs": [{"reference": "view0", "second": "view1"},
                      {"reference": "view9", "second": "view1"}]})");
  EXPECT_EQ(Error(), ": pairs[1].reference = 'view9': the scene has no such view");
  Write(R"({"pairs": [{"reference": "view0", "second": "view0"}]})");
  EXPECT_EQ(Error(), ": pairs[0] = view0, view0: one view twice");
  Write(R"({"pairs": [{"reference": "view0", "second": "view1"},
                      {"reference": "view0", "second": "view1"}]})");
  EXPECT_EQ(Error(), ": pairs[1] = view0, view1: appears twice");
}

}  // namespace
}  // namespace burin
