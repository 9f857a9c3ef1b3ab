// Visibility against closed forms: who hides whom, and that rounding hides nothing.
#include "core/visibility/visibility.h"

#include <gtest/gtest.h>

#include "core/visibility/facet_map.h"
#include "core/visibility/facet_pencil.h"
#include "tests/test_scene.h"

namespace burin {
namespace {

std::vector<Camera> CamerasOf(const std::vector<LevelView>& views) {
  std::vector<Camera> cameras;
  cameras.reserve(views.size());
  for (const LevelView& view : views) cameras.push_back(view.camera);
  return cameras;
}

TEST(Visibility, PixelListsCoverTheFacetMapOnce) {
  const TriangleMesh mesh = test::OccluderMesh();
  const auto views = test::RandomViews(96, 80);
  const std::vector<Camera> cameras = CamerasOf(views);
  const RayCaster caster(mesh);
  const auto domains = caster.Cast(cameras, {{0, 1}}, 0);
  const cv::Mat1i map = FacetMap(mesh, cameras[0]);
  std::vector<int> owner(96 * 80, -1);
  const ViewDomain& domain = domains[0];
  for (size_t k = 0; k < domain.facet.size(); ++k) {
    for (const ImagePixel pixel : domain.PixelsOf(k)) {
      EXPECT_EQ(owner[pixel.index], -1);
      owner[pixel.index] = domain.facet[k];
    }
  }
  for (int p = 0; p < 96 * 80; ++p) EXPECT_EQ(owner[p], map(p / 96, p % 96));
}

TEST(Visibility, ASingleSheetHidesNothingOfItself) {
  // A dense smooth sheet seen from both sides of its normal: every point is visible from every
  // camera, whatever rounding does at the many facet borders.
  TriangleMesh mesh;
  test::AppendGrid(&mesh, 150, 0, 0, 1.3,
                   [](double x, double y) { return 0.05 * std::sin(3 * x) * std::cos(2 * y); });
  const auto views = test::RandomViews(160, 120);
  const std::vector<Camera> cameras = CamerasOf(views);
  const auto domains = RayCaster(mesh).Cast(cameras, test::AllPairs(), -1e9);
  for (const ViewDomain& domain : domains) {
    for (int64_t pixels : domain.pair_pixels) {
      EXPECT_EQ(pixels, static_cast<int64_t>(domain.PixelCount()));
    }
  }
}

TEST(Visibility, ShadowOfALidHasItsArea) {
  // A lid of half side 0.2 at height 1 over a wall, cameras at height 5 on the axis and at x = 1.
  TriangleMesh mesh;
  test::AppendGrid(&mesh, 40, 0, 0, 2.0, [](double, double) { return 0.0; });
  test::AppendGrid(&mesh, 2, 0, 0, 0.2, [](double, double) { return 1.0; });
  const Camera above = test::LookAt({0, 0, 5}, {0, 0, 0}, 400, 400, 800);
  const Camera aside = test::LookAt({1, 0, 5}, {1, 0, 0}, 800, 800, 800);
  const auto domains = RayCaster(mesh).Cast({above, aside}, {{0, 1}}, 0);
  // Seen from above all pixels have a facet. Hidden from aside: the part of the wall in the lid's
  // shadow from there, a square of half side 0.25 around x = -0.25, less what the lid covers from
  // above, half side 0.25 around 0: the overlap is 0.25 wide, so 0.25 x 0.5 remains hidden. 160 px
  // a unit on the wall.
  const double hidden = 0.25 * 0.5 * 160 * 160;
  EXPECT_NEAR(400 * 400 - static_cast<double>(domains[0].pair_pixels[0]), hidden, 0.03 * hidden);
}

TEST(Visibility, PixelsAreSeenAsRaysOfTheirOwnSeeThem) {
  // Omega_ij is found without a ray where the second view's pixels tell; PointsVisible casts always.
  const TriangleMesh mesh = test::OccluderMesh();
  const auto views = test::RandomViews(192, 160);
  const std::vector<Camera> cameras = CamerasOf(views);
  const RayCaster caster(mesh);
  const auto domains = caster.Cast(cameras, test::AllPairs(), -1e9);
  int64_t compared = 0;
  int64_t different = 0;
  for (size_t i = 0; i < cameras.size(); ++i) {
    const ViewDomain& domain = domains[i];
    const ViewRays rays(cameras[i]);
    for (size_t b = 0; b < domain.seconds.size(); ++b) {
      std::vector<Eigen::Vector3d> points;
      std::vector<int> facets;
      std::vector<uint32_t> pixels;
      for (size_t k = 0; k < domain.facet.size(); ++k) {
        const InverseDepthPlane plane =
            MakeFacetPencil(mesh.vertices, mesh.faces[domain.facet[k]], rays).InverseDepth();
        for (const ImagePixel pixel : domain.PixelsOf(k)) {
          points.push_back(rays.SurfacePoint(pixel.x(), pixel.y(), plane));
          facets.push_back(domain.facet[k]);
          pixels.push_back(pixel.index);
        }
      }
      std::vector<uint8_t> visible;
      caster.PointsVisible(cameras[domain.seconds[b]], points, facets, &visible);
      int64_t hidden = 0;
      for (size_t n = 0; n < points.size(); ++n) {
        const int seen = domain.second_visible.Test(b, pixels[n]) ? 1 : 0;
        different += seen != visible[n] ? 1 : 0;
        hidden += visible[n] == 0 ? 1 : 0;
      }
      EXPECT_GT(hidden, 100);
      compared += static_cast<int64_t>(points.size());
    }
  }
  EXPECT_LT(static_cast<double>(different), 1e-3 * static_cast<double>(compared));
}

TEST(Visibility, FacetsSeenFromBehindAreNoPartOfTheDomain) {
  TriangleMesh mesh;
  test::AppendGrid(&mesh, 4, 0, 0, 1, [](double, double) { return 0.0; });
  for (auto& face : mesh.faces) std::swap(face[1], face[2]);
  const Camera camera = test::LookAt({0, 0, 5}, {0, 0, 0}, 64, 64, 64);
  const auto domains = RayCaster(mesh).Cast({camera, camera}, {{0, 1}}, 0);
  EXPECT_EQ(domains[0].PixelCount(), 0U);
}

TEST(Visibility, PixelsAreListedByTheirNearestCorner) {
  const TriangleMesh mesh = test::OccluderMesh();
  const std::vector<Camera> cameras = CamerasOf(test::RandomViews(96, 80));
  const auto domains = RayCaster(mesh).Cast(cameras, {{0, 1}}, 0);
  const ViewDomain& domain = domains[0];
  const ViewRays rays(cameras[0]);
  ASSERT_GT(domain.facet.size(), 100U);
  EXPECT_EQ(domain.start.size(), 3 * domain.facet.size() + 1);
  for (size_t k = 0; k < domain.facet.size(); ++k) {
    const Eigen::Matrix3d pencil =
        MakeFacetPencil(mesh.vertices, mesh.faces[domain.facet[k]], rays).coefficients;
    for (int c = 0; c < 3; ++c) {
      for (const ImagePixel pixel : domain.PixelsOf(k, c)) {
        const Eigen::Vector3d u = pencil * Eigen::Vector3d(pixel.x(), pixel.y(), 1);
        EXPECT_GE(u[c], u.maxCoeff() - 1e-9);
      }
    }
  }
}

// Facets up to 256 pixels wide and larger ones, whose lists differ.
TEST(Visibility, PixelListsOfLargeFacets) {
  TriangleMesh mesh;
  test::AppendGrid(&mesh, 2, 0, 0, 2, [](double, double) { return 0.0; });
  for (const int size : {200, 250, 270, 400}) {
    const Camera camera = test::LookAt({0.1, 0.2, 4}, {0.1, 0.2, 0}, 600, 500, size);
    const auto domains = RayCaster(mesh).Cast({camera, camera}, {{0, 1}}, 0);
    const cv::Mat1i map = FacetMap(mesh, camera);
    const ViewDomain& domain = domains[0];
    EXPECT_EQ(static_cast<int>(domain.PixelCount()), cv::countNonZero(map >= 0));
    uint32_t before = 0;
    for (size_t k = 0; k < domain.facet.size(); ++k) {
      for (int c = 0; c < 3; ++c) {
        bool first = true;
        for (const ImagePixel pixel : domain.PixelsOf(k, c)) {
          EXPECT_EQ(map(pixel.row, pixel.column), domain.facet[k]);
          EXPECT_EQ(pixel.index, static_cast<uint32_t>(600 * pixel.row + pixel.column));
          EXPECT_TRUE(first || pixel.index > before);
          first = false;
          before = pixel.index;
        }
      }
    }
  }
}

TEST(Visibility, FacetsSeenFromBehindHide) {
  // The lid of ShadowOfALidHasItsArea, turned over: the same shadow falls on the wall, and the lid itself is seen by none.
  TriangleMesh mesh;
  test::AppendGrid(&mesh, 40, 0, 0, 2.0, [](double, double) { return 0.0; });
  const size_t wall = mesh.faces.size();
  test::AppendGrid(&mesh, 2, 0, 0, 0.2, [](double, double) { return 1.0; });
  for (size_t f = wall; f < mesh.faces.size(); ++f) std::swap(mesh.faces[f][1], mesh.faces[f][2]);
  const Camera above = test::LookAt({0, 0, 5}, {0, 0, 0}, 400, 400, 800);
  const Camera aside = test::LookAt({1, 0, 5}, {1, 0, 0}, 800, 800, 800);
  const auto domains = RayCaster(mesh).Cast({above, aside}, {{0, 1}}, 0);
  const double lid = 0.5 * 0.5 * 160 * 160;
  const double hidden = 0.25 * 0.5 * 160 * 160;
  EXPECT_NEAR(400 * 400 - static_cast<double>(domains[0].PixelCount()), lid, 0.03 * lid);
  EXPECT_NEAR(400 * 400 - static_cast<double>(domains[0].pair_pixels[0]), lid + hidden,
              0.03 * (lid + hidden));
}

TEST(Visibility, ImagesOfOnePixelOrRow) {
  TriangleMesh mesh;
  test::AppendGrid(&mesh, 4, 0, 0, 1, [](double, double) { return 0.0; });
  const Camera camera = test::LookAt({0, 0, 5}, {0, 0, 0}, 64, 64, 64);
  for (const auto& [width, height] : {std::pair(1, 1), std::pair(1, 9), std::pair(9, 1)}) {
    const Camera small = camera.Resized(width, height);
    const auto domains = RayCaster(mesh).Cast({camera, small}, {{0, 1}, {1, 0}}, 0);
    EXPECT_EQ(domains[1].pair_pixels[0], static_cast<int64_t>(domains[1].PixelCount()));
    EXPECT_EQ(domains[0].pair_pixels[0], static_cast<int64_t>(domains[0].PixelCount()));
  }
}

// A pair's set of pixels is the same whether it is refined with or held back, and views that are the second one only keep
// no pixels.
TEST(Visibility, OtherPairsHaveTheirOwnRegions) {
  const TriangleMesh mesh = test::OccluderMesh();
  const std::vector<Camera> cameras = CamerasOf(test::RandomViews(96, 80));
  const RayCaster caster(mesh);
  const auto both = caster.Cast(cameras, {{0, 1}, {0, 2}, {1, 0}}, 0);
  std::vector<ViewPartners> others;
  const auto split = caster.Cast(cameras, {{0, 1}}, 0, {}, {{0, 2}, {1, 0}}, &others);
  ASSERT_EQ(others.size(), cameras.size());
  EXPECT_EQ(others[0].seconds, std::vector<int>{2});
  EXPECT_EQ(split[0].pair_pixels[0], both[0].pair_pixels[0]);
  EXPECT_EQ(others[0].pair_pixels[0], both[0].pair_pixels[1]);
  EXPECT_EQ(others[1].pair_pixels[0], both[1].pair_pixels[0]);
  EXPECT_EQ(split[1].PixelCount(), both[1].PixelCount());
  EXPECT_EQ(split[2].PixelCount(), 0U);
  for (size_t p = 0; p < size_t{96} * 80; ++p) {
    EXPECT_EQ(split[0].second_visible.Test(0, p), both[0].second_visible.Test(0, p));
    EXPECT_EQ(others[0].second_visible.Test(0, p), both[0].second_visible.Test(1, p));
  }
}

// Facets whose plane goes through a camera's centre, to rounding, on its lines of pixel centres: rays meet
// some of them and their planes say nothing. Points there were not a number, which passed every comparison
// and became an index, or a ray.
TEST(Visibility, FacetsSeenEdgeOnAreNoSurface) {
  const std::vector<Camera> cameras = {test::LookAt({0.13, 0.07, 3.1}, {0.13, 0.07, 0}, 97, 81, 90),
                                       test::LookAt({0.61, 0.21, 2.9}, {0, 0, 0}, 97, 81, 90)};
  const ViewRays rays(cameras[0]);
  for (const double spread : {0.4, 1e-3, 1e-9, 0.0}) {
    test::Random random(5);
    TriangleMesh mesh;
    test::AppendGrid(&mesh, 6, 0, 0, 1.3, [](double, double) { return 0.0; });
    const auto wall_faces = static_cast<int>(mesh.faces.size());
    for (int line = 0; line < 4 * cameras[0].height; ++line) {
      const auto base = static_cast<int>(mesh.vertices.size());
      for (int c = 0; c < 3; ++c) {
        const double depth = 2.5 + spread * random.Uniform();
        const Eigen::Vector3d pixel(48.5 + 48 * random.Uniform(), line / 4 + 0.5, 1);
        mesh.vertices.push_back(rays.center + depth * (rays.ray_from_pixel * pixel));
      }
      mesh.faces.emplace_back(base, base + 1, base + 2);
      mesh.faces.emplace_back(base, base + 2, base + 1);
    }
    const auto domains = RayCaster(mesh).Cast(cameras, {{0, 1}, {1, 0}}, 0);
    EXPECT_GT(domains[0].pair_pixels[0], 0);
    EXPECT_GT(domains[1].pair_pixels[0], 0);
    for (const int facet : domains[0].facet) EXPECT_LT(facet, wall_faces);
  }
}

}  // namespace
}  // namespace burin
