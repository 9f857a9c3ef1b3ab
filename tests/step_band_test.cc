// Pixels beside depth steps, and which of them still count.
#include "costs/step_band.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>

#include "core/refine/round.h"
#include "core/support/parallel.h"
#include "costs/photometric_energy.h"
#include "tests/test_scene.h"

namespace burin {
namespace {

constexpr int kSize = 15;
constexpr double kFocal = 100;

// A view of facets whose inverse depth is s(x, y) with the given slopes (0 = no surface).
DepthPlanes Planes(const std::function<double(int, int)>& s, float slope_x = 0, float slope_y = 0) {
  DepthPlanes planes;
  planes.width = planes.height = kSize;
  planes.focal = kFocal;
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      planes.inverse_depth.push_back(static_cast<float>(s(x, y)));
    }
  }
  planes.slope_x.assign(planes.inverse_depth.size(), slope_x);
  planes.slope_y.assign(planes.inverse_depth.size(), slope_y);
  planes.ray_length.assign(planes.inverse_depth.size(), 1);
  return planes;
}

// Row y of NearSteps with a limit of 3 footprints, '#' = near.
std::string Row(const DepthPlanes& planes, double band_px, int y = 7,
                const std::vector<uint8_t>& open_border = {}) {
  const std::vector<uint8_t> near = NearSteps(planes, open_border, 3, band_px);
  std::string text;
  for (int x = 0; x < kSize; ++x) text += near[y * kSize + x] != 0 ? '#' : '.';
  return text;
}

TEST(StepBand, WithinTheBandOnBothSidesOfAStep) {
  const DepthPlanes planes = Planes([](int x, int) { return x < 8 ? 0.1 : 0.05; });
  EXPECT_EQ(Row(planes, 0.5), ".......##......");
  EXPECT_EQ(Row(planes, 2), ".....######....");
}

TEST(StepBand, DistancesAreEuclidean) {
  // A single pixel in front: it and its four neighbours are of a step.
  const DepthPlanes planes = Planes([](int x, int y) { return x == 7 && y == 7 ? 0.2 : 0.1; });
  EXPECT_EQ(Row(planes, 0.5, 7), "......###......");
  EXPECT_EQ(Row(planes, 0.5, 6), ".......#.......");
  EXPECT_EQ(Row(planes, 1, 6), "......###......");
  EXPECT_EQ(Row(planes, 1, 4), "...............");
  EXPECT_EQ(Row(planes, 2.3, 4), "......###......");  // two rows and a column away: sqrt(5)
}

// A footprint at depth 10 is 0.1: steps of 2.5 and 3.5 px against the limit of 3.
TEST(StepBand, StepsAreMeasuredInPixelFootprints) {
  const auto step = [](double height) {
    return Planes([height](int x, int) { return x < 8 ? 1 / 10.0 : 1 / (10.0 + height); });
  };
  EXPECT_EQ(Row(step(0.25), 0.5), "...............");
  EXPECT_EQ(Row(step(0.36), 0.5), ".......##......");
}

// The depth changes by three footprints and more a pixel, as its plane says.
TEST(StepBand, AGrazingPlaneIsNoStep) {
  const auto s = [](int x, int y) { return 0.1 + 0.006 * x - 0.002 * y; };
  EXPECT_EQ(Row(Planes(s, 0.006F, -0.002F), 2), "...............");
  EXPECT_EQ(Row(Planes(s), 0.5), "###############");  // were the facets fronto-parallel
}

TEST(StepBand, WhereTheSurfaceEndsIsAStep) {
  const DepthPlanes planes = Planes([](int x, int) { return x < 8 ? 0.1 : 0.0; });
  EXPECT_EQ(Row(planes, 0.5), ".......##......");
}

struct Scene {
  Scene() : mesh(test::OccluderMesh()), views(test::RandomViews(96, 80)) {
    context = FreezeRound(views, test::AllPairs(), mesh, Motion::kNormal, 2, &domains);
    for (size_t i = 0; i < views.size(); ++i) {
      cameras.push_back(views[i].camera);
      near_steps.push_back(NearSteps(MakeDepthPlanes(domains[i], mesh, cameras[i]),
                                     OpenBorderPixels(domains[i], mesh, context.boundary), 3, 2));
    }
  }
  std::vector<PartnerBits> Without(double evidence) const {
    return WithoutSteps(domains, PartnersOf(domains), cameras, mesh, near_steps, evidence);
  }
  // Windows that count.
  int64_t Windows(double band_px, double evidence, bool first_level) const {
    PhotometricOptions options;
    options.mask.band_px = band_px;
    options.mask.evidence = evidence;
    PhotometricEnergy term(options);
    RoundContext frozen = context;
    frozen.first_level = first_level;
    term.BeginLevel(views);
    const std::unique_ptr<PhotometricRound> round = term.FreezeRound(frozen);
    round->Evaluate(mesh.vertices, false);
    return round->WindowCount();
  }
  TriangleMesh mesh;
  std::vector<LevelView> views;
  std::vector<ViewDomain> domains;
  RoundContext context;
  std::vector<Camera> cameras;
  std::vector<std::vector<uint8_t>> near_steps;
};

// Where the mesh was cut, the picture need not change. A step towards such a facet still is one.
TEST(StepBand, AnOpenBorderIsNoStep) {
  const DepthPlanes planes = Planes([](int x, int) { return x < 4 ? 0.2 : x < 8 ? 0.1 : 0.0; });
  std::vector<uint8_t> open(planes.inverse_depth.size(), 0);
  for (size_t p = 0; p < open.size(); ++p) open[p] = p % kSize > 2 ? 1 : 0;
  EXPECT_EQ(Row(planes, 0.5), "...##..##......");
  EXPECT_EQ(Row(planes, 0.5, 7, open), "...##..........");
}

TEST(StepBand, OpenBorderPixelsAreThoseOfFacetsAtTheRim) {
  const Scene scene;
  const std::vector<char> boundary = BoundaryVertices(scene.mesh, VertexFaces(scene.mesh));
  for (size_t i = 0; i < scene.domains.size(); ++i) {
    const ViewDomain& domain = scene.domains[i];
    const std::vector<uint8_t> open = OpenBorderPixels(domain, scene.mesh, boundary);
    std::vector<uint8_t> expected(open.size(), 0);
    for (size_t k = 0; k < domain.facet.size(); ++k) {
      const Eigen::Vector3i& face = scene.mesh.faces[domain.facet[k]];
      const bool rim = boundary[face[0]] + boundary[face[1]] + boundary[face[2]] > 0;
      for (const ImagePixel pixel : domain.PixelsOf(k)) expected[pixel.index] = rim ? 1 : 0;
    }
    EXPECT_EQ(open, expected);
    EXPECT_GT(std::count(open.begin(), open.end(), 1), 10);
  }
}

// With nothing asked of the evidence: the pixels that are near no step in either view.
TEST(StepBand, StepsOfBothViewsCount) {
  const Scene scene;
  const std::vector<PartnerBits> bits = scene.Without(0);
  int by_reference = 0;
  int by_second = 0;
  for (size_t i = 0; i < scene.views.size(); ++i) {
    const ViewDomain& domain = scene.domains[i];
    const DepthPlanes planes = MakeDepthPlanes(domain, scene.mesh, scene.cameras[i]);
    for (size_t k = 0; k < domain.facet.size(); ++k) {
      for (const ImagePixel pixel : domain.PixelsOf(k)) {
        const uint32_t p = pixel.index;
        const Camera& camera = scene.cameras[i];
        const Eigen::Vector3d point =
            camera.Center() +
            camera.Ray(pixel.x(), pixel.y()) / static_cast<double>(planes.inverse_depth[p]);
        for (size_t b = 0; b < domain.seconds.size(); ++b) {
          const bool visible = domain.second_visible.Test(b, p);
          const Camera& second = scene.cameras[domain.seconds[b]];
          const Eigen::Vector2d q = second.Project(point);
          // Depths are in single precision here: leave out what falls beside a pixel's edge.
          if (!visible || std::abs(q.x() - std::round(q.x())) < 1e-3 ||
              std::abs(q.y() - std::round(q.y())) < 1e-3) {
            continue;
          }
          const size_t q_pixel =
              static_cast<size_t>(q.y()) * second.width + static_cast<int>(q.x());
          const bool near_i = scene.near_steps[i][p] != 0;
          const bool near_j = scene.near_steps[domain.seconds[b]][q_pixel] != 0;
          by_reference += near_i && !near_j ? 1 : 0;
          by_second += near_j && !near_i ? 1 : 0;
          ASSERT_EQ(bits[i].Test(b, p), !near_i && !near_j) << i << " " << p;
        }
      }
    }
  }
  EXPECT_GT(by_reference, 100);
  EXPECT_GT(by_second, 100);
}

TEST(StepBand, NothingIsLostWhereNoEvidenceIsEnough) {
  const Scene scene;
  const std::vector<PartnerBits> bits = scene.Without(1e6);
  for (size_t i = 0; i < scene.views.size(); ++i) {
    EXPECT_TRUE(bits[i] == scene.domains[i].second_visible);
  }
}

// In between, a facet has all its pixels or those clear of steps, in all views alike.
TEST(StepBand, FacetsWithLittleEvidenceKeepTheirPixels) {
  const Scene scene;
  const std::vector<PartnerBits> clear = scene.Without(0);
  const std::vector<PartnerBits> bits = scene.Without(3);
  std::vector<char> lost(scene.mesh.faces.size(), 0);
  std::vector<char> kept(scene.mesh.faces.size(), 0);
  for (size_t i = 0; i < scene.views.size(); ++i) {
    const ViewDomain& domain = scene.domains[i];
    for (size_t k = 0; k < domain.facet.size(); ++k) {
      for (const ImagePixel pixel : domain.PixelsOf(k)) {
        // All partners of a pixel are in one byte.
        const uint8_t all = domain.second_visible.Of(0).bytes[pixel.index];
        const uint8_t far = clear[i].Of(0).bytes[pixel.index];
        const uint8_t used = bits[i].Of(0).bytes[pixel.index];
        if (far == all) continue;
        ASSERT_TRUE(used == far || used == all);
        (used == far ? lost : kept)[domain.facet[k]] = 1;
      }
    }
  }
  int lose = 0;
  int keep = 0;
  for (size_t f = 0; f < lost.size(); ++f) {
    EXPECT_FALSE(lost[f] != 0 && kept[f] != 0) << f;
    lose += lost[f];
    keep += kept[f];
  }
  EXPECT_GT(lose, 10);
  EXPECT_GT(keep, 10);
}

TEST(StepBand, TheEnergyLeavesThemOutFromTheSecondLevelOn) {
  const Scene scene;
  const int64_t all = scene.Windows(0, 3, false);
  EXPECT_GT(all, 1000);
  EXPECT_LT(scene.Windows(2, 3, false), 0.99 * static_cast<double>(all));
  EXPECT_GT(scene.Windows(2, 3, false), 0.3 * static_cast<double>(all));
  EXPECT_EQ(scene.Windows(2, 1e6, false), all);
  EXPECT_EQ(scene.Windows(2, 3, true), all);
}

TEST(StepBand, TheSameForAnyNumberOfThreads) {
  const Scene scene;
  const ThreadScope one_thread(1);
  const std::vector<PartnerBits> one = scene.Without(3);
  const ThreadScope four_threads(4);
  const std::vector<PartnerBits> four = scene.Without(3);
  EXPECT_TRUE(one == four);
}

}  // namespace
}  // namespace burin
