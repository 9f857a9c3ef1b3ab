// The vectorised kernel against windows summed one by one, for every size of window, and its
// targets (instruction sets) against each other.
#include "costs/pair_kernel.h"

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <cmath>
#include <memory>

#include "core/refine/round.h"
#include "costs/photometric_energy.h"
#include "costs/warp_picture.h"
#include "tests/test_scene.h"

namespace burin {
namespace {

struct Round {
  explicit Round(const PhotometricOptions& given)
      : Round(given, test::RandomViews(97, 83), test::AllPairs()) {}  // no multiple of any vector
  Round(const PhotometricOptions& given, std::vector<LevelView> given_views,
        const std::vector<CameraPair>& pairs)
      : options(given), views(std::move(given_views)) {
    mesh = test::OccluderMesh();
    context = FreezeRound(views, pairs, mesh, Motion::kNormal, 2, &domains);
    term = std::make_unique<PhotometricEnergy>(options);
    term->BeginLevel(views);
    energy = term->FreezeRound(context);
  }
  PhotometricOptions options;
  TriangleMesh mesh;
  std::vector<LevelView> views;
  std::vector<ViewDomain> domains;
  RoundContext context;
  std::unique_ptr<PhotometricEnergy> term;
  std::unique_ptr<PhotometricRound> energy;
};

PhotometricOptions Options(int window, MaskMode mask, bool double_precision) {
  PhotometricOptions options;
  options.window = window;
  options.mask.mode = mask;
  options.mask.band_px = 0;
  options.min_valid_share = 0.4;
  options.double_precision = double_precision;
  return options;
}

// Sum and number of the windows' errors, each window summed from its taps in double.
std::pair<double, int> OneByOne(const Round& round) {
  double energy = 0;
  int windows = 0;
  for (size_t i = 0; i < round.views.size(); ++i) {
    const ViewDomain& domain = round.domains[i];
    const WindowMasks& masks = round.energy->masks(static_cast<int>(i));
    for (size_t b = 0; b < domain.seconds.size(); ++b) {
      const WarpPicture pair = MakeWarpPicture(round.views, static_cast<int>(i), domain,
                                               static_cast<int>(b), round.mesh);
      const cv::Mat1f errors = WindowErrors(round.views[i], round.views[domain.seconds[b]], pair,
                                            round.options, masks.size() > 0 ? &masks : nullptr);
      for (const float error : errors) {
        energy += error;
        windows += error != 0 ? 1 : 0;
      }
    }
  }
  return {energy, windows};
}

TEST(PairKernel, EnergyIsThatOfWindowsSummedOneByOne) {
  for (const int window : {3, 5, 7, 9, 17, 31}) {
    for (const MaskMode mask : {MaskMode::kNone, MaskMode::kPlane}) {
      for (const bool double_precision : {false, true}) {
        const Round round(Options(window, mask, double_precision));
        const double energy = round.energy->Evaluate(round.mesh.vertices, true);
        const auto [expected, windows] = OneByOne(round);
        ASSERT_GT(windows, 1000);
        EXPECT_EQ(round.energy->WindowCount(), windows) << window << " " << NameOf(mask);
        EXPECT_NEAR(energy, expected, 2e-5 * expected) << window << " " << NameOf(mask);
      }
    }
  }
}

// Tiles are 512 x 96 pixels: windows reach over their borders.
TEST(PairKernel, SeveralTilesAreAsOne) {
  for (const int window : {5, 9}) {
    const Round round(Options(window, MaskMode::kPlane, true), test::RandomViews(531, 101),
                      {{0, 1}, {2, 1}});
    const double energy = round.energy->Evaluate(round.mesh.vertices, true);
    const auto [expected, windows] = OneByOne(round);
    ASSERT_GT(windows, 20000);
    EXPECT_EQ(round.energy->WindowCount(), windows) << window;
    EXPECT_NEAR(energy, expected, 2e-5 * expected) << window;
    double shares = 0;
    const CornerSumsList& sums = round.energy->corner_sums();
    for (size_t c = 0; c < sums.size(); ++c) shares += sums[c].share;
    EXPECT_NEAR(shares, energy, 1e-9 * energy) << window;
  }
}

// Partners are bits, eight to a byte.
TEST(PairKernel, MoreThanEightPartners) {
  std::vector<CameraPair> pairs;
  for (int second = 1; second < 12; ++second) pairs.push_back({0, second});
  const Round round(Options(5, MaskMode::kPlane, false), test::RandomViews(97, 83, 12), pairs);
  ASSERT_EQ(round.domains[0].seconds.size(), 11U);
  const double energy = round.energy->Evaluate(round.mesh.vertices, true);
  const auto [expected, windows] = OneByOne(round);
  ASSERT_GT(windows, 10000);
  EXPECT_EQ(round.energy->WindowCount(), windows);
  EXPECT_NEAR(energy, expected, 2e-5 * expected);
}

// Beyond the image a coordinate is clamped by itself: the value still changes along the other.
TEST(SplineImage, GradientIsThatOfTheValueWhereOneCoordinateIsClamped) {
  const SplineImage<double> spline(test::RandomViews(40, 30)[0].FloatImage(), 0.0);
  constexpr double kStep = 1e-5;
  for (const auto& [x, y] : std::vector<std::pair<double, double>>{
           {-9.0, 11.3}, {51.0, 11.3}, {17.4, -9.0}, {17.4, 41.0}, {-9.0, 41.0}, {17.4, 11.3}}) {
    double value = 0;
    double gradient[2];
    spline.Sample(x, y, &value, &gradient[0], &gradient[1]);
    double side[4];
    spline.Sample(x + kStep, y, &side[0]);
    spline.Sample(x - kStep, y, &side[1]);
    spline.Sample(x, y + kStep, &side[2]);
    spline.Sample(x, y - kStep, &side[3]);
    EXPECT_NEAR(gradient[0], (side[0] - side[1]) / (2 * kStep), 1e-5) << x << " " << y;
    EXPECT_NEAR(gradient[1], (side[2] - side[3]) / (2 * kStep), 1e-5) << x << " " << y;
  }
}

TEST(PairKernel, SingleAgreesWithDoubleForEverySizeOfWindow) {
  for (const int window : {3, 5, 9, 31}) {
    const Round fast(Options(window, MaskMode::kPlane, false));
    const Round exact(Options(window, MaskMode::kPlane, true));
    fast.energy->Evaluate(fast.mesh.vertices, true);
    exact.energy->Evaluate(exact.mesh.vertices, true);
    double error[2] = {0, 0};
    double norm[2] = {0, 0};
    for (size_t c = 0; c < exact.energy->corner_sums().size(); ++c) {
      const CornerSums a = fast.energy->corner_sums()[c];
      const CornerSums b = exact.energy->corner_sums()[c];
      error[0] += std::pow(a.slope[0] - b.slope[0], 2);
      norm[0] += std::pow(b.slope[0], 2);
      error[1] += std::pow(a.curvature[3] - b.curvature[3], 2);
      norm[1] += std::pow(b.curvature[3], 2);
    }
    EXPECT_LT(std::sqrt(error[0] / norm[0]), 1e-4) << window;
    EXPECT_LT(std::sqrt(error[1] / norm[1]), 1e-4) << window;
  }
}

// The energy alone and with derivatives goes through different code for halos and rows.
TEST(PairKernel, EnergyDoesNotDependOnDerivatives) {
  Round round(Options(5, MaskMode::kPlane, false));
  const double with = round.energy->Evaluate(round.mesh.vertices, true);
  round.energy = round.term->FreezeRound(round.context);
  EXPECT_EQ(round.energy->Evaluate(round.mesh.vertices, false), with);
}

TEST(PairKernel, EveryInstructionSetGivesTheSame) {
  for (const int window : {3, 5, 7, 9}) {
    double slope_sum = 0;
    double first = 0;
    int targets = 0;
    for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
      hwy::SetSupportedTargetsForTest(target);
      hwy::GetChosenTarget().DeInit();
      const Round round(Options(window, MaskMode::kPlane, false));
      const double energy = round.energy->Evaluate(round.mesh.vertices, true);
      double sum = 0;
      const CornerSumsList& sums = round.energy->corner_sums();
      for (size_t c = 0; c < sums.size(); ++c) sum += std::abs(sums[c].slope[1]);
      if (targets++ == 0) {
        first = energy;
        slope_sum = sum;
      }
      EXPECT_NEAR(energy, first, 1e-6 * first) << window << " " << hwy::TargetName(target);
      EXPECT_NEAR(sum, slope_sum, 1e-5 * slope_sum) << window << " " << hwy::TargetName(target);
    }
    EXPECT_GE(targets, 1);
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().DeInit();
}

}  // namespace
}  // namespace burin
