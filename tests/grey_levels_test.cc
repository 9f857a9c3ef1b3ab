// Grey values times a factor: the same photographs, and the same mesh to noise.
#include <gtest/gtest.h>

#include <cmath>

#include "apps/run/pipeline.h"
#include "core/evaluate/evaluation.h"
#include "core/image/grey_statistics.h"
#include "core/synthetic/synthetic.h"
#include "costs/grey_units.h"
#include "tests/split_facets.h"

namespace burin {
namespace {

SyntheticScene SmallScene() {
  SyntheticOptions options;
  options.width = 240;
  options.height = 180;
  options.samples_per_axis = 2;
  options.truth_point_count = 1000;
  options.point_count = 500;
  return MakeSyntheticScene(options);
}

// What a file with `depth` holds of grey levels times `factor`, as ReadGrayImage returns it.
cv::Mat Stored(const cv::Mat& gray, double factor, int depth) {
  cv::Mat stored;
  cv::Mat levels;
  gray.convertTo(stored, depth, depth == CV_16U ? 257 * factor : factor);
  if (depth != CV_16U) return stored;
  stored.convertTo(levels, CV_32F, 1 / 257.0);
  return levels;
}

TEST(GreyLevels, TimesAFactorEndInTheSameMesh) {
  const SyntheticScene made = SmallScene();
  const auto error_px = [&](double factor, int depth) {
    Scene scene = made.scene;
    for (View& view : scene.views) view.gray = Stored(view.gray, factor, depth);
    return RmseToTruthMesh(RunPipeline(scene, made.init, test::SplitFacets()).mesh, made.truth,
                           20000) /
           made.footprint;
  };
  const double whole = error_px(1, CV_8U);
  EXPECT_LT(whole, 0.2 * RmseToTruthMesh(made.init, made.truth, 20000) / made.footprint);
  const struct {
    double factor;
    int depth;
    double tolerance;
  } cases[] = {{1.0 / 16, CV_16U, 0.02},  {1.0 / 256, CV_16U, 0.02},   {1.0 / 16, CV_32F, 0.02},
               {1.0 / 256, CV_32F, 0.02}, {1.0 / 65536, CV_32F, 0.02}, {1.0 / 4, CV_8U, 0.05}};
  for (const auto& c : cases) {
    const double error = error_px(c.factor, c.depth);
    RecordProperty("rmse_px_" + std::to_string(c.factor) + "_" + std::to_string(c.depth),
                   std::to_string(error));
    EXPECT_NEAR(error, whole, c.tolerance * whole) << c.factor << " depth " << c.depth;
  }
}

TEST(GreyLevels, UnitsFollowThePhotographs) {
  const SyntheticScene made = SmallScene();
  const auto units = [&](double factor, double shift, const PhotometricOptions& options) {
    Scene scene = made.scene;
    for (View& view : scene.views) view.gray.convertTo(view.gray, CV_32F, factor, shift);
    return UnitsOf(MakeLevelViews(scene, 1, Eigen::Vector3d::Zero(), 1)[0], options);
  };
  PhotometricOptions options;
  const GreyUnits whole = units(1, 0, options);
  EXPECT_GT(whole.unit, 3);
  EXPECT_LT(whole.unit, 8);
  for (const double factor : {0.25, 1 / 64.0, 1 / 256.0}) {
    const GreyUnits scaled = units(factor, 20, options);
    EXPECT_NEAR(scaled.unit, factor * whole.unit, 1e-4 * factor * whole.unit);
    EXPECT_NEAR(scaled.offset, factor * whole.offset + 20, 1e-3);
  }
  options.variance_floor = 49;
  EXPECT_EQ(units(1, 0, options).unit, 7);
  EXPECT_EQ(units(0.25, 0, options).unit, 7);
  LevelView flat;
  flat.image = cv::Mat1f(32, 32, 7.0F);
  EXPECT_EQ(UnitsOf(flat, PhotometricOptions()).unit, 1);
  // Noise alone sets the floor of a photograph with nothing else.
  flat.photo_noise_sigma = 4;
  flat.contrast = 4;
  EXPECT_EQ(UnitsOf(flat, PhotometricOptions()).unit, 6);
}

TEST(GreyLevels, TextureDoesNotAskHowMuchIsTextured) {
  cv::Mat1f texture(64, 64);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) texture(y, x) = 100 + ((x + y) % 2 == 0 ? 10 : -10);
  }
  // 12 or 13 of a window's 25 taps are bright.
  const double expected = 10 * std::sqrt(1 - 1 / 625.0);
  EXPECT_NEAR(SampleGreys(texture, cv::Mat()).texture, expected, 1e-6);
  cv::Mat1f half = texture.clone();
  half.colRange(32, 64) = 100;
  EXPECT_NEAR(SampleGreys(half, cv::Mat()).texture, expected, 0.3);
  cv::Mat mask(64, 64, CV_8UC1, cv::Scalar(255));
  mask.colRange(32, 64) = 0;
  half.colRange(32, 64) = 0;  // a bright edge, masked
  const GreySample masked = SampleGreys(half, mask);
  EXPECT_NEAR(masked.texture, expected, 1e-6);
  EXPECT_EQ(masked.levels.size(), 28u * 60u);
  EXPECT_EQ(SampleGreys(cv::Mat1f(20, 20, 3.0F), cv::Mat()).texture, 0);
}

TEST(GreyLevels, ContrastIsOfRangeAndTexture) {
  EXPECT_EQ(Contrast({}), 0);
  EXPECT_EQ(Contrast({GreySample()}), 0);
  GreySample dark;
  GreySample bright;
  for (int k = 0; k < 3000; ++k) {
    dark.levels.push_back(static_cast<float>(k % 100));
    bright.levels.push_back(static_cast<float>(100 + k % 101));
  }
  dark.levels[0] = -5000;  // one pixel does not stretch the range
  dark.texture = 8;
  bright.texture = 3;
  EXPECT_NEAR(Contrast({dark, bright, dark}), std::sqrt(200 * 8.0), 0.2);
}

}  // namespace
}  // namespace burin
