// Depth by stereo, on a rendered scene whose surface is known.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/mesh/closest_point.h"
#include "core/support/median.h"
#include "core/support/parallel.h"
#include "core/synthetic/synthetic.h"
#include "reconstruct/dense_points.h"
#include "reconstruct/depth_files.h"
#include "reconstruct/rectified_pair.h"
#include "reconstruct/stereo_pairs.h"
#include "reconstruct/stereo_views.h"

namespace burin {
namespace {

const SyntheticScene& Relief() {
  static const SyntheticScene scene = [] {
    SyntheticOptions options;
    options.scene = SyntheticKind::kRelief;
    options.width = 320;
    options.height = 240;
    return MakeSyntheticScene(options);
  }();
  return scene;
}

std::vector<Eigen::Vector3d> PointsOf(const Scene& scene) {
  std::vector<Eigen::Vector3d> points;
  for (const ScenePoint& point : scene.points) points.push_back(point.position);
  return points;
}

TEST(StereoPairs, AreWithinTheAnglesAndTheBestOfThem) {
  const Scene& scene = Relief().scene;
  const auto partners = ChooseStereoPartners(scene, {});
  for (size_t i = 0; i < partners.size(); ++i) {
    EXPECT_GE(partners[i].size(), 1);
    EXPECT_LE(partners[i].size(), 4);
    for (const int j : partners[i]) EXPECT_NE(j, static_cast<int>(i));
  }
  StereoRules none;
  none.min_angle_deg = 80;
  none.max_angle_deg = 90;
  for (const std::vector<int>& of : ChooseStereoPartners(scene, none)) EXPECT_TRUE(of.empty());
}

// A world point lies on one row of both rectified pictures, and its disparity gives its depth.
TEST(RectifiedPair, PutsPointsOnOneRowAndKnowsTheirDepth) {
  const Scene& scene = Relief().scene;
  const Camera& a = scene.views[2].camera;
  const Camera& b = scene.views[3].camera;
  const auto pair = Rectify(a, b, PointsOf(scene));
  ASSERT_TRUE(pair.has_value());
  EXPECT_EQ(pair->disparity_count % 16, 0);
  const cv::Mat2f places[2] = {pair->SamplePlaces(0, a), pair->SamplePlaces(1, b)};
  for (const auto& [row, column, disparity] : {std::array<int, 3>{40, 60, 3}, {100, 120, 7}}) {
    const double depth = 1 / pair->InverseDepth(pair->min_disparity + disparity);
    const Eigen::Vector3d ray((column - pair->shift[0]) / pair->focal,
                              (row - pair->row_shift) / pair->focal, 1);
    const Eigen::Vector3d world = a.Center() + depth * (pair->rotation.transpose() * ray);
    const Eigen::Vector2d in_a = a.Project(world);
    EXPECT_NEAR(in_a.x() - 0.5, places[0](row, column)[0], 1e-3);
    EXPECT_NEAR(in_a.y() - 0.5, places[0](row, column)[1], 1e-3);
    const int other = column - pair->min_disparity - disparity;
    ASSERT_TRUE(other >= 0 && other < pair->width);
    const Eigen::Vector2d in_b = b.Project(world);
    EXPECT_NEAR(in_b.x() - 0.5, places[1](row, other)[0], 1e-3);
    EXPECT_NEAR(in_b.y() - 0.5, places[1](row, other)[1], 1e-3);
  }
}

TEST(RectifiedPair, RefusesABaselineAlongTheLineOfSight) {
  const Scene& scene = Relief().scene;
  const Camera& a = scene.views[2].camera;
  Camera b = a;
  b.translation.z() -= 0.3;  // straight on
  EXPECT_FALSE(Rectify(a, b, PointsOf(scene)).has_value());
  EXPECT_FALSE(Rectify(a, a, PointsOf(scene)).has_value());
}

TEST(FusePairs, TakesWhatMostAgreeOnByItsWeights) {
  const auto map = [](float depth, float sigma) {
    return DepthMap{cv::Mat1f(1, 2, depth), cv::Mat1f(1, 2, sigma)};
  };
  const std::vector<DepthMap> pairs = {map(9, 0.1F), map(5, 0.1F), {}, map(5.15F, 0.2F)};
  cv::Mat1b mask(1, 2, std::uint8_t{255});
  mask(0, 1) = 0;
  const FusedDepth fused = FusePairs(pairs, mask, 2);
  EXPECT_NEAR(fused.map.depth(0, 0), (100 * 5 + 25 * 5.15) / 125, 1e-5);
  EXPECT_NEAR(fused.map.sigma(0, 0), 1 / std::sqrt(125.0), 1e-6);
  EXPECT_EQ(fused.pairs(0, 0), 0b1010);
  EXPECT_EQ(fused.map.depth(0, 1), 0);  // masked
  EXPECT_EQ(FusePairs(pairs, {}, 3).map.depth(0, 0), 0);
}

TEST(StereoViews, FindTheSurfaceAndAreReadAgain) {
  const Scene& scene = Relief().scene;
  StereoViewsRules rules;
  std::string folder = (std::filesystem::path(testing::TempDir()) / "depths XXXXXX").string();
  ASSERT_NE(mkdtemp(folder.data()), nullptr);
  rules.folder = folder;
  const auto nothing = [](double /*share*/) {};
  StereoViews first;
  {
    const ThreadScope threads(1);
    first = MatchViews(scene, rules, nothing);
  }
  EXPECT_EQ(first.read, 0);
  EXPECT_EQ(first.matched, static_cast<int>(scene.views.size()));
  const StereoViews again = MatchViews(scene, rules, nothing);
  EXPECT_EQ(again.read, first.matched);
  rules.folder.clear();
  const ThreadScope threads(3);
  const StereoViews anew = MatchViews(scene, rules, nothing);
  for (size_t v = 0; v < scene.views.size(); ++v) {
    for (const StereoViews* other : {&again, &anew}) {
      const FusedDepth& a = first.depths[v];
      const FusedDepth& b = other->depths[v];
      EXPECT_EQ(cv::norm(a.map.depth, b.map.depth, cv::NORM_INF), 0);
      EXPECT_EQ(cv::norm(a.map.sigma, b.map.sigma, cv::NORM_INF), 0);
      EXPECT_EQ(cv::norm(a.pairs, b.pairs, cv::NORM_INF), 0);
      EXPECT_EQ(a.partners, b.partners);
    }
  }
  std::filesystem::remove_all(folder);

  SightedPoints points;
  AddDensePoints(scene, first.depths, {}, &points);
  EXPECT_GT(points.Count(), 300);
  const MeshDistance truth(Relief().truth);
  std::vector<double> errors;
  for (int p = 0; p < points.Count(); ++p) {
    errors.push_back(truth.Find(points.positions[p]).distance / points.footprints[p]);
    EXPECT_GE(points.SightCount(p), 2);
  }
  EXPECT_LT(Median(errors), 1);
}

}  // namespace
}  // namespace burin
