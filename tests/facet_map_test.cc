// Facets that pixels see, against every facet tried at every pixel, and against rays.
#include "core/visibility/facet_map.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "core/support/parallel.h"
#include "core/visibility/facet_pencil.h"
#include "core/visibility/mesh_rays.h"
#include "tests/test_scene.h"

namespace burin {
namespace {

// The nearest facet whose barycentric coordinates are all positive; `clear`: no coordinate is within rounding of zero.
int NearestFacet(const TriangleMesh& mesh, const Camera& camera, double x, double y, bool* clear) {
  const Eigen::Vector3d center = camera.Center();
  const Eigen::Vector3d ray = camera.Ray(x, y);
  int nearest = -1;
  double depth = std::numeric_limits<double>::infinity();
  *clear = true;
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    Eigen::Matrix3d corners;
    for (int k = 0; k < 3; ++k) corners.col(k) = mesh.vertices[mesh.faces[f][k]] - center;
    const Eigen::Vector3d u = corners.inverse() * ray;
    const double largest = u.cwiseAbs().maxCoeff();
    if (!std::isfinite(largest)) continue;
    if (u.cwiseAbs().minCoeff() < 1e-9 * largest && u.minCoeff() > -1e-9 * largest) *clear = false;
    if (u.minCoeff() < 0) continue;
    const double here = 1 / u.sum();
    if (here <= camera.near_depth || here >= depth) continue;
    depth = here;
    nearest = static_cast<int>(f);
  }
  return nearest;
}

void ExpectNearestEverywhere(const TriangleMesh& mesh, const Camera& camera) {
  const cv::Mat1i map = FacetMap(mesh, camera);
  int compared = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      bool clear = false;
      const int nearest = NearestFacet(mesh, camera, x + 0.5, y + 0.5, &clear);
      if (!clear) continue;
      ASSERT_EQ(map(y, x), nearest) << x << " " << y;
      ++compared;
    }
  }
  EXPECT_GT(compared, camera.width * camera.height * 9 / 10);
}

// Triangles of all sizes anywhere around the camera: behind it, through its plane, small, seen from both sides.
TriangleMesh TrianglesAround(int count, double size, uint64_t seed) {
  test::Random random(seed);
  TriangleMesh mesh;
  for (int f = 0; f < count; ++f) {
    const Eigen::Vector3d at = 2 * random.Vector();
    const auto first = static_cast<int>(mesh.vertices.size());
    for (int k = 0; k < 3; ++k) mesh.vertices.push_back(at + size * random.Vector());
    mesh.faces.emplace_back(first, first + 1, first + 2);
  }
  return mesh;
}

TEST(FacetMap, IsTheNearestFacetAtEveryPixel) {
  for (const double size : {0.02, 0.3, 3.0}) {
    for (const uint64_t seed : {1, 2, 3}) {
      const TriangleMesh mesh = TrianglesAround(120, size, seed);
      Camera camera = test::LookAt({0.1, 0.05, 0.3}, {0.4, 0.2, -1}, 61, 47, 40);
      ExpectNearestEverywhere(mesh, camera);
      camera.near_depth = 0.7;
      ExpectNearestEverywhere(mesh, camera);
    }
  }
}

TEST(FacetMap, HasNoGapAndNoFacetTooManyAtEdges) {
  // A flat grid whose edges run through pixel centres: along rows, columns and diagonals.
  TriangleMesh mesh;
  test::AppendGrid(&mesh, 20, 0, 0, 2, [](double, double) { return 0.0; });
  const Camera camera = test::LookAt({0.0125, -0.0125, 4}, {0.0125, -0.0125, 0}, 101, 101, 160);
  cv::Mat1i covered(101, 101, 0);
  const cv::Mat1i map = FacetMap(mesh, camera);
  EXPECT_EQ(cv::countNonZero(map < 0), 0);
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    const TriangleMesh alone{mesh.vertices, {mesh.faces[f]}};
    covered += (FacetMap(alone, camera) >= 0) / 255;
  }
  EXPECT_EQ(cv::countNonZero(covered != 1), 0);
  // From behind too.
  TriangleMesh turned = mesh;
  for (Eigen::Vector3i& face : turned.faces) std::swap(face[0], face[1]);
  EXPECT_EQ(cv::countNonZero(FacetMap(turned, camera) < 0), 0);
}

TEST(FacetMap, AgreesWithRays) {
  const TriangleMesh mesh = test::OccluderMesh();
  const MeshRays rays(mesh);
  int different = 0;
  int pixels = 0;
  for (const LevelView& view : test::RandomViews(192, 160)) {
    const cv::Mat1i map = FacetMap(mesh, view.camera);
    for (int y = 0; y < map.rows; ++y) {
      for (int x = 0; x < map.cols; ++x) {
        RayHit hit;
        rays.Intersect(view.camera.Center(), view.camera.Ray(x + 0.5, y + 0.5), &hit);
        different += hit.face == map(y, x) ? 0 : 1;
        ++pixels;
      }
    }
  }
  RecordProperty("different", different);
  EXPECT_LT(different, pixels / 10000);
}

TEST(FacetMap, OfFacetsThatSayNothingIsEmpty) {
  const Camera camera = test::LookAt({0, 0, 4}, {0, 0, 0}, 32, 32, 32);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  TriangleMesh mesh;
  mesh.vertices = {{-1, -1, 0}, {1, -1, 0}, {0, 1, nan}, {0, inf, 0}, {1e300, 1e300, 0},
                   {0, 0, 4},   {-1, 0, 0}, {1, 0, 0},   {0, 0, 0}};
  mesh.faces = {{0, 1, 2}, {0, 1, 3}, {0, 1, 0}, {5, 6, 7}, {6, 7, 8}};
  const cv::Mat1i map = FacetMap(mesh, camera);
  EXPECT_EQ(cv::countNonZero(map >= 0), 0);
  mesh.faces = {{0, 1, 4}};
  FacetMap(mesh, camera);  // no crash
  EXPECT_EQ(cv::countNonZero(FacetMap(TriangleMesh(), camera) >= 0), 0);
}

TEST(FacetMap, IsTheSameForAnyNumberOfThreads) {
  const TriangleMesh mesh = TrianglesAround(3000, 0.1, 5);
  const Camera camera = test::LookAt({0, 0, 3}, {0, 0, 0}, 211, 157, 150);
  const cv::Mat1i whole = FacetMap(mesh, camera);
  EXPECT_GT(cv::countNonZero(whole >= 0), 211 * 157 / 4);
  for (const int threads : {1, 3}) {
    const ThreadScope scope(threads);
    EXPECT_EQ(cv::countNonZero(FacetMap(mesh, camera) != whole), 0);
  }
}

TEST(FacetMap, IsTheSameWithEveryInstructionSet) {
  // Edges through pixel centres, facets wider than a vector, slivers; rounding may differ at edges.
  const TriangleMesh mesh = TrianglesAround(2000, 0.15, 7);
  const Camera camera = test::LookAt({0, 0, 3}, {0, 0, 0}, 211, 157, 150);
  const cv::Mat1i chosen = FacetMap(mesh, camera);
  const std::vector<int64_t> targets = hwy::SupportedAndGeneratedTargets();
  ASSERT_FALSE(targets.empty());
  for (const int64_t target : targets) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    EXPECT_LE(cv::countNonZero(FacetMap(mesh, camera) != chosen), 3) << hwy::TargetName(target);
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

// A facet that goes over the right border draws nothing at the left one of the next row.
TEST(FacetMap, EndsAtTheImage) {
  const Camera camera = test::LookAt({0, 0, 4}, {0, 0, 0}, 33, 21, 30);
  TriangleMesh mesh;
  const ViewRays rays(camera);
  for (const auto& [x, y] : {std::pair(29.0, -5.0), std::pair(80.0, 10.0), std::pair(29.0, 40.0)}) {
    mesh.vertices.push_back(rays.center + rays.ray_from_pixel * Eigen::Vector3d(x, y, 1));
  }
  mesh.faces = {{0, 1, 2}};
  const cv::Mat1i map = FacetMap(mesh, camera);
  EXPECT_EQ(cv::countNonZero(map(cv::Rect(0, 0, 29, 21)) >= 0), 0);
  EXPECT_EQ(cv::countNonZero(map(cv::Rect(29, 0, 4, 21)) < 0), 0);
}

TEST(CornerMap, HoldsTheNearestCornerAndTheDepth) {
  const TriangleMesh mesh = test::OccluderMesh();
  const Camera camera = test::RandomViews(96, 80)[0].camera;
  const CornerMap map(mesh, camera);
  const ViewRays rays(camera);
  int seen = 0;
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const int code = map.CodeAt(x, y);
      if (code < 0) {
        EXPECT_EQ(map.InverseDepthAt(x, y), 0);
        continue;
      }
      const auto [facet, corner] = FacetCorner::Of(code);
      const FacetPencil pencil = MakeFacetPencil(mesh.vertices, mesh.faces[facet], rays);
      const Eigen::Vector3d u = pencil.coefficients * Eigen::Vector3d(x + 0.5, y + 0.5, 1);
      EXPECT_GE(u[corner], u.maxCoeff() - 1e-9);
      EXPECT_NEAR(map.InverseDepthAt(x, y), u.sum(), 1e-6 * u.sum());
      const InverseDepthPlane plane = MakeInverseDepth(mesh.vertices, mesh.faces[facet], rays);
      EXPECT_NEAR(plane.At(x + 0.5, y + 0.5), u.sum(), 1e-9 * u.sum());
      ++seen;
    }
  }
  EXPECT_GT(seen, 96 * 80 / 2);
}

}  // namespace
}  // namespace burin
