// Masks of windows on depth maps whose steps are known.
#include "costs/occlusion_mask.h"

#include <gtest/gtest.h>

#include <functional>
#include <numeric>

#include "core/refine/round.h"
#include "tests/test_scene.h"

namespace burin {
namespace {

constexpr int kSize = 15;
constexpr int kRadius = 2;
constexpr double kFocal = 100;

// A view of fronto-parallel facets at the given distances (0 = no surface): parallel rays, so that
// distance and depth are the same.
DepthPlanes Planes(const std::function<double(int, int)>& depth) {
  DepthPlanes planes;
  planes.width = planes.height = kSize;
  planes.focal = kFocal;
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const double z = depth(x, y);
      planes.inverse_depth.push_back(z > 0 ? static_cast<float>(1 / z) : 0.0F);
    }
  }
  planes.slope_x.assign(planes.inverse_depth.size(), 0);
  planes.slope_y.assign(planes.inverse_depth.size(), 0);
  planes.ray_length.assign(planes.inverse_depth.size(), 1);
  return planes;
}

// A single plane whose inverse depth is affine in the pixel.
DepthPlanes Slanted() {
  DepthPlanes planes = Planes([](int x, int y) { return 1 / (0.1 + 0.004 * x - 0.002 * y); });
  std::fill(planes.slope_x.begin(), planes.slope_x.end(), 0.004F);
  std::fill(planes.slope_y.begin(), planes.slope_y.end(), -0.002F);
  return planes;
}

// The mask of the window at (x, y), rows from the top, as '#' (valid) and '.'.
std::string Mask(const DepthPlanes& planes, MaskMode mode, int x = 7, int y = 7) {
  const std::vector<char> mask = WindowMask(planes, x, y, kRadius, mode, 6);
  std::string text;
  for (size_t k = 0; k < mask.size(); ++k) {
    if (k > 0 && k % 5 == 0) text += ' ';
    text += mask[k] != 0 ? '#' : '.';
  }
  return text;
}

std::string Rows(const std::string& row) {
  return row + " " + row + " " + row + " " + row + " " + row;
}

const std::string kAll = Rows("#####");
const std::string kNone = Rows(".....");

TEST(OcclusionMask, ConstantDepth) {
  const DepthPlanes planes = Planes([](int, int) { return 10.0; });
  EXPECT_EQ(Mask(planes, MaskMode::kNone), kAll);
  EXPECT_EQ(Mask(planes, MaskMode::kPaper), kAll);
  EXPECT_EQ(Mask(planes, MaskMode::kPlane), kAll);
  EXPECT_EQ(Mask(planes, MaskMode::kPaperStrict), kNone);  // |0 - 0| < 10 |0 - 0|
}

TEST(OcclusionMask, SlantedPlane) {
  EXPECT_EQ(Mask(Slanted(), MaskMode::kPaper), kAll);
  EXPECT_EQ(Mask(Slanted(), MaskMode::kPlane), kAll);
  // The tap at M is always lost.
  EXPECT_NE(Mask(Slanted(), MaskMode::kPaperStrict), kAll);
}

// As printed, dd over columns -2 s .. 2 s: sigma = -2 s, and only the last column fails.
TEST(OcclusionMask, PrintedRuleOnADepthRamp) {
  const DepthPlanes planes = Planes([](int x, int) { return 10.0 + x; });
  EXPECT_EQ(Mask(planes, MaskMode::kPaperStrict), Rows("####."));
}

// Seen from the near side of a step the far taps go, and the other way round.
TEST(OcclusionMask, StepFromNearAndFarSide) {
  const DepthPlanes planes = Planes([](int x, int) { return x < 8 ? 10.0 : 15.0; });
  for (const MaskMode mode : {MaskMode::kPaper, MaskMode::kPlane}) {
    EXPECT_EQ(Mask(planes, mode, 7), Rows("###.."));  // near side, step right of the centre
    EXPECT_EQ(Mask(planes, mode, 8), Rows("..###"));  // far side
    EXPECT_EQ(Mask(planes, mode, 5), kAll);           // away from it
  }
  EXPECT_EQ(Mask(planes, MaskMode::kPaperStrict, 7), Rows("###.."));
  EXPECT_EQ(Mask(planes, MaskMode::kPaperStrict, 8), Rows("##..."));  // only the occluder
}

// Two steps in one window: columns at 0, 0, 0, 5, 10. The factor 10 keeps the first step.
TEST(OcclusionMask, TheFactorTenKeepsAStepHalfAsHigh) {
  const DepthPlanes planes = Planes([](int x, int) {
    return x <= 7 ? 10.0 : x == 8 ? 15.0 : 20.0;
  });
  EXPECT_EQ(Mask(planes, MaskMode::kPaperStrict), Rows("####."));
  EXPECT_EQ(Mask(planes, MaskMode::kPaper), Rows("####."));
  EXPECT_EQ(Mask(planes, MaskMode::kPlane), Rows("###.."));
}

TEST(OcclusionMask, ThinBarInFrontOfAWall) {
  const DepthPlanes planes = Planes([](int x, int) { return x == 8 ? 5.0 : 10.0; });
  for (const MaskMode mode : {MaskMode::kPaper, MaskMode::kPlane}) {
    EXPECT_EQ(Mask(planes, mode, 7), Rows("###.#"));  // on the wall beside the bar
    EXPECT_EQ(Mask(planes, mode, 8), Rows("..#.."));  // on the bar
  }
}

// Beside a single step there are better windows two pixels on; on a bar of two pixels there are none.
TEST(OcclusionMask, ThinIsWhereNoNeighbourKeepsEnough) {
  const auto thin_columns = [](const DepthPlanes& planes) {
    const WindowMasks masks = MakeWindowMasks(planes, kRadius, MaskMode::kPlane, 6, 20);
    std::vector<int> columns;
    for (size_t entry = masks.row_start[7]; entry < masks.row_start[8]; ++entry) {
      if (masks.thin[entry] != 0) columns.push_back(masks.column[entry]);
    }
    return columns;
  };
  const DepthPlanes step = Planes([](int x, int) { return x < 8 ? 10.0 : 15.0; });
  EXPECT_EQ(thin_columns(step), std::vector<int>());
  const DepthPlanes bar = Planes([](int x, int) { return x == 7 || x == 8 ? 5.0 : 10.0; });
  EXPECT_EQ(thin_columns(bar), (std::vector<int>{7, 8}));
}

TEST(OcclusionMask, PatchHalfOffTheMesh) {
  const DepthPlanes planes = Planes([](int x, int) { return x < 8 ? 10.0 : 0.0; });
  EXPECT_EQ(Mask(planes, MaskMode::kPaper), Rows("###.."));
  EXPECT_EQ(Mask(planes, MaskMode::kPlane), Rows("###.."));
  // As printed with M infinite, all taps with a surface are valid.
  EXPECT_EQ(Mask(planes, MaskMode::kPaperStrict), Rows("###.."));
  // Such a window is not listed: Omega_ij leaves these taps out anyway.
  for (const MaskMode mode : {MaskMode::kPaper, MaskMode::kPlane}) {
    EXPECT_EQ(MakeWindowMasks(planes, kRadius, mode, 6, 20).size(), 0U);
  }
}

TEST(OcclusionMask, PlaneThresholdIsInPixelFootprints) {
  // A footprint at depth 10 is 0.1: a step of 0.55 is 5.5 px, one of 0.65 is 6.5 px.
  const auto step = [](double height) {
    return Planes([height](int x, int) { return x < 8 ? 10.0 : 10.0 + height; });
  };
  EXPECT_EQ(Mask(step(0.55), MaskMode::kPlane), kAll);
  EXPECT_EQ(Mask(step(0.65), MaskMode::kPlane), Rows("###.."));
}

// The list of masks holds what WindowMask says of every window, in order.
TEST(OcclusionMask, ListHoldsTheWindowsThatAreNotFull) {
  const TriangleMesh mesh = test::OccluderMesh();
  const std::vector<LevelView> views = test::RandomViews(96, 80);
  std::vector<ViewDomain> domains;
  FreezeRound(views, test::AllPairs(), mesh, Motion::kNormal, 2, &domains);
  const DepthPlanes planes = MakeDepthPlanes(domains[1], mesh, views[1].camera);
  for (const MaskMode mode : {MaskMode::kPaperStrict, MaskMode::kPaper, MaskMode::kPlane}) {
    const WindowMasks masks = MakeWindowMasks(planes, kRadius, mode, 3, 20);
    size_t entry = 0;
    for (int y = 0; y < planes.height; ++y) {
      EXPECT_EQ(masks.row_start[y], entry);
      for (int x = 0; x < planes.width; ++x) {
        if (planes.inverse_depth[static_cast<size_t>(y) * planes.width + x] == 0) continue;
        const std::vector<char> mask = WindowMask(planes, x, y, kRadius, mode, 3);
        const bool listed =
            entry < masks.size() && entry < masks.row_start[y + 1] && masks.column[entry] == x;
        for (int k = 0; k < 25; ++k) {
          const int tap_x = x + k % 5 - kRadius;
          const int tap_y = y + k / 5 - kRadius;
          const bool inside =
              tap_x >= 0 && tap_x < planes.width && tap_y >= 0 && tap_y < planes.height &&
              planes.inverse_depth[static_cast<size_t>(tap_y) * planes.width + tap_x] != 0;
          if (!inside) continue;
          ASSERT_EQ(listed ? masks.Has(entry, k % 5 - kRadius, k / 5 - kRadius) : true,
                    mask[k] != 0)
              << x << " " << y << " tap " << k;
        }
        entry += listed ? 1 : 0;
      }
    }
    EXPECT_EQ(entry, masks.size());
    EXPECT_GT(entry, 100U);
  }
}

// A curved surface without steps loses nothing.
TEST(OcclusionMask, ASmoothSurfaceIsNotMasked) {
  TriangleMesh mesh;
  test::AppendGrid(&mesh, 30, 0, 0, 1.3,
                   [](double x, double y) { return 0.08 * std::sin(3 * x) * std::cos(2 * y); });
  const std::vector<LevelView> views = test::RandomViews(96, 80);
  std::vector<ViewDomain> domains;
  FreezeRound(views, test::AllPairs(), mesh, Motion::kNormal, 2, &domains);
  const DepthPlanes planes = MakeDepthPlanes(domains[0], mesh, views[0].camera);
  EXPECT_EQ(MakeWindowMasks(planes, kRadius, MaskMode::kPlane, 6, 20).size(), 0U);
  EXPECT_EQ(MakeWindowMasks(planes, kRadius, MaskMode::kPaper, 6, 20).size(), 0U);
}

}  // namespace
}  // namespace burin
