// The scenes that show what a refiner does without evidence: each has what synthetic.h says.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <tuple>
#include <vector>

#include "core/support/parallel.h"
#include "core/synthetic/synthetic.h"
#include "core/visibility/ray_render.h"
#include "tests/synthetic_bytes.h"

namespace burin {
namespace {

constexpr SyntheticKind kAll[] = {SyntheticKind::kRods, SyntheticKind::kPlates,
                                  SyntheticKind::kMembrane, SyntheticKind::kSky,
                                  SyntheticKind::kBoulder};
constexpr int kRods = 8;

SyntheticOptions SmallOptions(SyntheticKind scene) {
  SyntheticOptions options;
  options.scene = scene;
  options.width = 160;
  options.height = 120;
  options.views = 5;
  options.samples_per_axis = 2;
  options.init_edge_px = 20;
  options.point_count = 200;
  options.truth_point_count = 20000;
  return options;
}

// Made once for all tests.
const SyntheticScene& SmallScene(SyntheticKind kind) {
  static auto* scenes = new std::map<SyntheticKind, SyntheticScene>();
  const auto found = scenes->find(kind);
  return found != scenes->end()
             ? found->second
             : scenes->emplace(kind, MakeSyntheticScene(SmallOptions(kind))).first->second;
}

cv::Mat1f DepthOf(const TriangleMesh& mesh, const Camera& camera) {
  const MeshRays rays(mesh);
  return RenderDepth(rays, camera);
}

// Share of a camera's pixels at which `mesh` is nearer than `share` of the truth's depth.
double HiddenShare(const SyntheticScene& synthetic, const TriangleMesh& mesh, int view,
                   double share) {
  const cv::Mat1f depth = DepthOf(mesh, synthetic.scene.views[view].camera);
  const double scale = share * cv::mean(synthetic.depth[view], synthetic.depth[view] > 0)[0];
  const cv::Mat hidden = (depth > 0) & (depth < scale);
  return cv::countNonZero(hidden) / static_cast<double>(hidden.total());
}

// Where a line along z through (x, y) meets the mesh, in px, falling.
std::vector<double> Crossings(const SyntheticScene& synthetic, const MeshRays& rays, double x,
                              double y) {
  std::vector<double> found;
  RayHit hit;
  Eigen::Vector3d from(x, y, 1);
  while (rays.Intersect(from, -Eigen::Vector3d::UnitZ(), &hit)) {
    found.push_back(hit.point.z() / synthetic.footprint);
    from.z() = hit.point.z() - 1e-3 * synthetic.footprint;
  }
  return found;
}

class SyntheticEvidence : public testing::TestWithParam<SyntheticKind> {
 protected:
  const SyntheticScene& synthetic() const { return SmallScene(GetParam()); }
};
INSTANTIATE_TEST_SUITE_P(All, SyntheticEvidence, testing::ValuesIn(kAll),
                         [](const auto& scene) { return NameOf(scene.param); });

TEST_P(SyntheticEvidence, SameSeedGivesTheSameBytesForAnyThreadCount) {
  const ThreadScope one_thread(1);
  const std::string once = Bytes(MakeSyntheticScene(SmallOptions(GetParam())));
  const ThreadScope three_threads(3);
  EXPECT_TRUE(once == Bytes(MakeSyntheticScene(SmallOptions(GetParam()))));
}

TEST_P(SyntheticEvidence, AnotherSeedGivesAnotherScene) {
  SyntheticOptions options = SmallOptions(GetParam());
  options.seed = 2;
  const SyntheticScene other = MakeSyntheticScene(options);
  EXPECT_NE(synthetic().init.vertices, other.init.vertices);
  cv::Mat difference;
  cv::absdiff(synthetic().scene.views[1].gray, other.scene.views[1].gray, difference);
  EXPECT_GT(cv::mean(difference, synthetic().depth[1] > 0)[0], 5);
}

TEST_P(SyntheticEvidence, HasWhatEverySceneHas) {
  EXPECT_EQ(synthetic().scene.views.size(), 5U);
  EXPECT_EQ(synthetic().depth.size(), 5U);
  EXPECT_GT(synthetic().truth_points.size(), 1000U);
  EXPECT_EQ(synthetic().truth_points.size(), synthetic().truth_normals.size());
  EXPECT_GT(synthetic().scene.points.size(), 150U);
  for (const ScenePoint& point : synthetic().scene.points) EXPECT_GE(point.views.size(), 2U);
}

TEST_P(SyntheticEvidence, WhatIsHitFirstLooksAtTheCamera) {
  for (const TriangleMesh* mesh : {&synthetic().truth, &synthetic().init}) {
    const MeshRays rays(*mesh);
    int front = 0;
    int back = 0;
    for (const View& view : synthetic().scene.views) {
      for (int row = 0; row < view.camera.height; row += 2) {
        for (int col = 0; col < view.camera.width; ++col) {
          RayHit hit;
          const Eigen::Vector3d ray = view.camera.Ray(col + 0.5, row + 0.5);
          if (!rays.Intersect(view.camera.Center(), ray, &hit)) continue;
          (FaceAreaNormal(*mesh, hit.face).dot(ray) < 0 ? front : back) += 1;
        }
      }
    }
    EXPECT_GT(front, 1000);
    EXPECT_LT(back, 0.001 * front);
  }
}

TEST(SyntheticRods, AreAsWideInTheImageAsTheyShouldBe) {
  const SyntheticScene& synthetic = SmallScene(SyntheticKind::kRods);
  const TriangleMesh& truth = synthetic.truth;
  const Camera& camera = synthetic.scene.views[2].camera;
  const MeshRays rays(truth);
  const auto faces_per_rod = static_cast<int>(truth.faces.size()) / kRods;
  constexpr int kRaysPerPixel = 8;
  double area[kRods] = {};
  for (int row = 0; row < camera.height; ++row) {
    for (int col = 0; col < camera.width * kRaysPerPixel; ++col) {
      RayHit hit;
      const Eigen::Vector3d ray = camera.Ray((col + 0.5) / kRaysPerPixel, row + 0.5);
      if (!rays.Intersect(camera.Center(), ray, &hit)) continue;
      area[hit.face / faces_per_rod] += 1.0 / kRaysPerPixel;
    }
  }
  const size_t vertices_per_rod = truth.vertices.size() / kRods;
  const double diameters[kRods] = {1, 1, 1.5, 1.5, 2, 2, 3, 3};
  for (int k = 0; k < kRods; ++k) {
    // The last two vertices of a rod are the middles of its ends.
    const Eigen::Vector3d* last = &truth.vertices[(k + 1) * vertices_per_rod - 1];
    const double length = (camera.Project(last[0]) - camera.Project(last[-1])).norm();
    EXPECT_GT(length, 70);
    // Nearer than the centre, and away from the image's middle, a rod is a little wider.
    const Eigen::Vector3d middle = camera.rotation * (last[0] + last[-1]) / 2 + camera.translation;
    const double scale = camera.fx * synthetic.footprint * middle.norm() / std::pow(middle.z(), 2);
    EXPECT_NEAR(area[k] / length, scale * diameters[k], 0.02 * diameters[k]);
  }
}

TEST(SyntheticRods, StandInFrontOfNothing) {
  SyntheticOptions options = SmallOptions(SyntheticKind::kRods);
  options.noise_sigma = 0;
  options.exposure_spread = 0;
  const SyntheticScene clean = MakeSyntheticScene(options);
  for (size_t v = 0; v < clean.depth.size(); ++v) {
    const cv::Mat rods = clean.depth[v] > 0;
    cv::Mat near_rods;
    cv::dilate(rods, near_rods, cv::Mat::ones(5, 5, CV_8U));
    const cv::Mat& photograph = clean.scene.views[v].gray;
    // A few pixels of a rod that passes beside all the centres around.
    EXPECT_LT(cv::countNonZero((near_rods == 0) & (photograph != 25)), 10);
    EXPECT_GT(cv::mean(photograph, rods)[0], 50);
    cv::Scalar mean;
    cv::Scalar sigma;
    cv::meanStdDev(photograph, mean, sigma, rods);
    EXPECT_GT(sigma[0], 10);
  }
}

TEST(SyntheticRods, StartThickerAndBent) {
  const SyntheticScene& synthetic = SmallScene(SyntheticKind::kRods);
  constexpr int kSides = 8;
  const size_t per_rod = synthetic.init.vertices.size() / kRods;
  const size_t truth_per_rod = synthetic.truth.vertices.size() / kRods;
  const double diameters[kRods] = {1, 1, 1.5, 1.5, 2, 2, 3, 3};
  for (int k = 0; k < kRods; ++k) {
    const Eigen::Vector3d* end = &synthetic.truth.vertices[(k + 1) * truth_per_rod - 2];
    const Eigen::Vector3d axis = (end[1] - end[0]).normalized();
    const size_t rings = (per_rod - 2) / kSides;
    double squared_bend = 0;
    double radius = 0;
    for (size_t r = 0; r < rings; ++r) {
      const Eigen::Vector3d* ring = &synthetic.init.vertices[k * per_rod + r * kSides];
      Eigen::Vector3d middle = Eigen::Vector3d::Zero();
      for (int s = 0; s < kSides; ++s) middle += ring[s] / kSides;
      const Eigen::Vector3d offset = middle - end[0];
      squared_bend += (offset - axis * axis.dot(offset)).squaredNorm();
      for (int s = 0; s < kSides; ++s) radius += (ring[s] - middle).norm() / kSides;
    }
    const double count = static_cast<double>(rings);
    EXPECT_GT(std::sqrt(squared_bend / count) / synthetic.footprint, 0.4);
    EXPECT_LT(std::sqrt(squared_bend / count) / synthetic.footprint, 1.1);
    EXPECT_NEAR(radius / count / synthetic.footprint, diameters[k] / 2 + 0.7, 0.15);
  }
}

TEST(SyntheticPlates, HaveTheGapInTruthAndInit) {
  for (const auto& [seed, gap_px] : {std::tuple(1, 4.0), {2, 4.0}, {3, 4.0}, {1, 2.0}, {2, 8.0}}) {
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", gap " << gap_px);
    SyntheticOptions options = SmallOptions(SyntheticKind::kPlates);
    options.seed = seed;
    options.gap_px = gap_px;
    options.samples_per_axis = 1;
    const SyntheticScene synthetic = MakeSyntheticScene(options);
    const MeshRays truth(synthetic.truth);
    const MeshRays init(synthetic.init);
    double squared = 0;
    int count = 0;
    for (double x = -0.7; x < 0.71; x += 0.1) {
      for (double y = -0.5; y < 0.51; y += 0.1) {
        const std::vector<double> exact = Crossings(synthetic, truth, x, y);
        const std::vector<double> start = Crossings(synthetic, init, x, y);
        ASSERT_EQ(exact.size(), 4U);
        ASSERT_EQ(start.size(), 4U);
        for (int layer = 0; layer < 3; ++layer) {
          EXPECT_NEAR(exact[layer] - exact[layer + 1], gap_px, 1e-3);
          EXPECT_GT(start[layer] - start[layer + 1], 0.15 * gap_px);
        }
        for (int side = 0; side < 4; ++side) {
          squared += (exact[side] - start[side]) * (exact[side] - start[side]);
          ++count;
        }
      }
    }
    EXPECT_GT(std::sqrt(squared / count), 0.08 * gap_px);
    EXPECT_LT(std::sqrt(squared / count), 0.3 * gap_px);
  }
}

TEST(SyntheticPlates, AreSeenFromBothSides) {
  const SyntheticScene& synthetic = SmallScene(SyntheticKind::kPlates);
  for (int v = 0; v < 5; ++v) {
    EXPECT_EQ(synthetic.scene.views[v].camera.Center().z() > 0, v < 3);
    EXPECT_GT(cv::countNonZero(synthetic.depth[v] > 0), 120 * 160 / 4);
  }
  const auto front = std::count_if(synthetic.truth_points.begin(), synthetic.truth_points.end(),
                                   [](const Eigen::Vector3d& point) { return point.z() > 0; });
  const double share = static_cast<double>(front) / synthetic.truth_points.size();
  EXPECT_NEAR(share, 0.5, 0.05);
}

TEST(SyntheticMembrane, HidesAThirdOfOneViewAndIsNowhereElse) {
  const SyntheticScene& synthetic = SmallScene(SyntheticKind::kMembrane);
  for (int v = 0; v < 5; ++v) {
    EXPECT_NEAR(HiddenShare(synthetic, synthetic.init, v, 0.5), v == 2 ? 1.0 / 3 : 0, 0.03) << v;
    EXPECT_EQ(HiddenShare(synthetic, synthetic.truth, v, 0.5), 0) << v;
  }
  // But for the sheet it is the scene relief.
  const SyntheticScene relief = MakeSyntheticScene([] {
    SyntheticOptions options = SmallOptions(SyntheticKind::kMembrane);
    options.scene = SyntheticKind::kRelief;
    return options;
  }());
  EXPECT_EQ(relief.truth.vertices, synthetic.truth.vertices);
  EXPECT_EQ(relief.truth_points, synthetic.truth_points);
  for (int v = 0; v < 5; ++v) {
    EXPECT_EQ(cv::norm(relief.scene.views[v].gray, synthetic.scene.views[v].gray), 0);
  }
  const size_t sheet = synthetic.init.faces.size() - relief.init.faces.size();
  EXPECT_GT(sheet, 200U);
  EXPECT_LT(sheet, 1000U);
}

TEST(SyntheticSky, ShowsNothingButNoiseAndTheInitIsInItAllTheSame) {
  const SyntheticScene& synthetic = SmallScene(SyntheticKind::kSky);
  for (int v = 0; v < 5; ++v) {
    cv::Mat surface;
    cv::dilate(synthetic.depth[v] > 0, surface, cv::Mat());
    const cv::Mat sky = surface == 0;
    const double sky_pixels = cv::countNonZero(sky);
    EXPECT_GT(sky_pixels, 0.2 * static_cast<double>(sky.total()));
    EXPECT_LT(sky_pixels, 0.6 * static_cast<double>(sky.total()));
    cv::Scalar mean;
    cv::Scalar sigma;
    cv::meanStdDev(synthetic.scene.views[v].gray, mean, sigma, sky);
    EXPECT_GT(mean[0], 150);
    EXPECT_NEAR(sigma[0], 1.5, 0.15);
    const cv::Mat1f init = DepthOf(synthetic.init, synthetic.scene.views[v].camera);
    EXPECT_GT(cv::countNonZero(sky & (init > 0)), 0.08 * sky_pixels);
    EXPECT_LT(cv::countNonZero(sky & (init > 0)), 0.6 * sky_pixels);
  }
}

TEST(SyntheticSky, TowerAndGroundStartCoarse) {
  const SyntheticScene& synthetic = SmallScene(SyntheticKind::kSky);
  // Straight down on the tower and beside it: the tower starts too large, the ground without bumps.
  const MeshRays truth(synthetic.truth);
  const MeshRays init(synthetic.init);
  double squared = 0;
  int count = 0;
  for (double x = -1.5; x < 1.51; x += 0.1) {
    for (double z = 0.3; z < 0.95; z += 0.1) {
      RayHit exact;
      RayHit start;
      ASSERT_TRUE(truth.Intersect({x, 1, z}, -Eigen::Vector3d::UnitY(), &exact));
      ASSERT_TRUE(init.Intersect({x, 1, z}, -Eigen::Vector3d::UnitY(), &start));
      squared += std::pow((exact.distance - start.distance) / synthetic.footprint, 2);
      ++count;
    }
  }
  EXPECT_GT(std::sqrt(squared / count), 1);
  EXPECT_LT(std::sqrt(squared / count), 3);
  RayHit top;
  ASSERT_TRUE(init.Intersect({0, 1, 0}, -Eigen::Vector3d::UnitY(), &top));
  EXPECT_NEAR(top.point.y(), 0.5, 4 * synthetic.footprint);
  EXPECT_LT(synthetic.init.faces.size(), synthetic.truth.faces.size() / 20);
}

TEST(SyntheticBoulder, IsClosedAndSeenAllAround) {
  const SyntheticScene& synthetic = SmallScene(SyntheticKind::kBoulder);
  for (const TriangleMesh* mesh : {&synthetic.truth, &synthetic.init}) {
    const Adjacency faces = VertexFaces(*mesh);
    for (const char border : BoundaryVertices(*mesh, faces)) EXPECT_EQ(border, 0);
  }
  EXPECT_LT(synthetic.init.faces.size(), synthetic.truth.faces.size() / 20);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Camera& camera : synthetic.true_cameras) sum += camera.Center().normalized();
  EXPECT_LT(std::hypot(sum.x(), sum.z()) / 5, 0.1);  // they cancel around the upright axis
  for (const cv::Mat1f& depth : synthetic.depth) {
    EXPECT_GT(cv::countNonZero(depth > 0), depth.total() / 5);
  }
}

}  // namespace
}  // namespace burin
