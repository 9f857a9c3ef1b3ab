#include "core/synthetic/synthetic.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/mesh/point_cloud_io.h"
#include "core/scene/formats/scene_loader.h"
#include "core/support/error.h"
#include "core/support/parallel.h"
#include "core/synthetic/synthetic_shapes.h"
#include "core/visibility/ray_render.h"
#include "tests/synthetic_bytes.h"

namespace burin {
namespace {

constexpr SyntheticKind kAll[] = {SyntheticKind::kRelief, SyntheticKind::kOccluders,
                                  SyntheticKind::kScan};

SyntheticOptions SmallOptions(SyntheticKind scene) {
  SyntheticOptions options;
  options.scene = scene;
  options.views = 3;
  options.width = 128;
  options.height = 96;
  options.init_edge_px = 18;
  options.point_count = 300;
  return options;
}

TriangleMesh BumpySphere() {
  return BodyMesh({{1, 1, 1}, 0, true}, 0.06, [](const Eigen::Vector3d& point) {
    return 0.05 * std::sin(9 * point.x()) * std::sin(8 * point.y() + 1);
  });
}

SyntheticScene MakeSmallScene(SyntheticKind kind) {
  SyntheticOptions options = SmallOptions(kind);
  if (kind == SyntheticKind::kScan) options.views = 20;
  return MakeSyntheticScene(options, kind == SyntheticKind::kScan ? BumpySphere() : TriangleMesh());
}

// Made once for all tests.
const SyntheticScene& SmallScene(SyntheticKind kind) {
  static auto* scenes = new std::map<SyntheticKind, SyntheticScene>();
  const auto found = scenes->find(kind);
  return found != scenes->end() ? found->second
                                : scenes->emplace(kind, MakeSmallScene(kind)).first->second;
}

// Samples at (x, y), pixel centres at half-integers.
float Sample(const cv::Mat1f& image, const Eigen::Vector2d& at) {
  cv::Mat1f patch;
  cv::getRectSubPix(image, {1, 1},
                    cv::Point2f(static_cast<float>(at.x() - 0.5), static_cast<float>(at.y() - 0.5)),
                    patch);
  return patch(0, 0);
}

struct Agreement {
  double mean_zncc = 0;
  int windows = 0;
};

// Mean ZNCC of 5x5 windows of view i with view j warped through `mesh`, over the windows of which
// every point is seen in both views at less than 60 degrees from its normal (more slanted, the
// texture's detail is finer than the pixels).
Agreement WarpAgreement(const SyntheticScene& synthetic, const TriangleMesh& mesh, int i, int j) {
  const MeshRays rays(mesh);
  const View& first = synthetic.scene.views[i];
  const View& second = synthetic.scene.views[j];
  cv::Mat1f reference;
  cv::Mat1f other;
  first.gray.convertTo(reference, CV_32F);
  second.gray.convertTo(other, CV_32F);
  cv::Mat1f warped(reference.size(), -1.0F);
  for (int row = 0; row < reference.rows; ++row) {
    for (int col = 0; col < reference.cols; ++col) {
      RayHit hit;
      const Camera& camera = first.camera;
      if (!rays.Intersect(camera.Center(), camera.Ray(col + 0.5, row + 0.5), &hit)) continue;
      const Eigen::Vector3d normal = FaceAreaNormal(mesh, hit.face).normalized();
      if (!rays.Sees(second.camera, hit.point, normal)) continue;
      const auto slanted = [&](const Camera& seen_by) {
        return normal.dot((seen_by.Center() - hit.point).normalized()) < 0.5;
      };
      if (slanted(camera) || slanted(second.camera)) continue;
      warped(row, col) = Sample(other, second.camera.Project(hit.point));
    }
  }
  Agreement agreement;
  for (int row = 2; row + 2 < reference.rows; ++row) {
    for (int col = 2; col + 2 < reference.cols; ++col) {
      const cv::Rect window(col - 2, row - 2, 5, 5);
      double least = 0;
      cv::minMaxLoc(warped(window), &least);
      if (least < 0) continue;
      cv::Mat1f zncc;
      cv::matchTemplate(reference(window), warped(window), zncc, cv::TM_CCOEFF_NORMED);
      agreement.mean_zncc += zncc(0, 0);
      ++agreement.windows;
    }
  }
  agreement.mean_zncc /= std::max(1, agreement.windows);
  return agreement;
}

// RMS over view 0's pixels of the depth between two meshes, in px.
double RmsDepthDifference(const SyntheticScene& synthetic, const TriangleMesh& mesh) {
  const MeshRays rays(mesh);
  const Camera& camera = synthetic.scene.views[0].camera;
  const cv::Mat1f found = RenderDepth(rays, camera);
  double sum = 0;
  int count = 0;
  for (int row = 0; row < found.rows; ++row) {
    for (int col = 0; col < found.cols; ++col) {
      const double truth = synthetic.depth[0](row, col);
      if (truth <= 0 || found(row, col) <= 0) continue;
      const double difference = (found(row, col) - truth) / synthetic.footprint;
      sum += difference * difference;
      ++count;
    }
  }
  return std::sqrt(sum / count);
}

// Share of the points of view i inside view j's image and facing it that another surface hides.
double HiddenShare(const SyntheticScene& synthetic, int i, int j) {
  const MeshRays rays(synthetic.truth);
  const Camera& first = synthetic.scene.views[i].camera;
  const Camera& second = synthetic.scene.views[j].camera;
  int facing = 0;
  int hidden = 0;
  for (int row = 0; row < first.height; ++row) {
    for (int col = 0; col < first.width; ++col) {
      RayHit hit;
      if (!rays.Intersect(first.Center(), first.Ray(col + 0.5, row + 0.5), &hit)) continue;
      const Eigen::Vector3d normal = FaceAreaNormal(synthetic.truth, hit.face);
      if (!second.Contains(second.Project(hit.point))) continue;
      if (normal.dot(second.Center() - hit.point) <= 0) continue;
      ++facing;
      if (!rays.Sees(second, hit.point, normal)) ++hidden;
    }
  }
  return static_cast<double>(hidden) / facing;
}

TEST(Synthetic, SameSeedGivesTheSameBytesForAnyThreadCount) {
  for (const SyntheticKind scene : kAll) {
    SCOPED_TRACE(NameOf(scene));
    const ThreadScope one_thread(1);
    const std::string once = Bytes(MakeSmallScene(scene));
    const ThreadScope two_threads(2);
    const std::string again = Bytes(SmallScene(scene));
    EXPECT_TRUE(once == again);
  }
}

TEST(Synthetic, AnotherSeedGivesAnotherScene) {
  SyntheticOptions options = SmallOptions(SyntheticKind::kRelief);
  const SyntheticScene first = MakeSyntheticScene(options);
  options.seed = 2;
  const SyntheticScene second = MakeSyntheticScene(options);
  EXPECT_NE(first.truth.vertices, second.truth.vertices);
  EXPECT_NE(first.init.vertices, second.init.vertices);
  cv::Mat difference;
  cv::absdiff(first.scene.views[1].gray, second.scene.views[1].gray, difference);
  EXPECT_GT(cv::mean(difference)[0], 10);
}

class SyntheticScenes : public testing::TestWithParam<SyntheticKind> {
 protected:
  const SyntheticScene& synthetic() const { return SmallScene(GetParam()); }
};
INSTANTIATE_TEST_SUITE_P(All, SyntheticScenes, testing::ValuesIn(kAll),
                         [](const auto& scene) { return NameOf(scene.param); });

TEST_P(SyntheticScenes, ImagesAgreeThroughTheTruthAndLessThroughTheInit) {
  for (const auto& [i, j] : {std::pair<int, int>(0, 1), {2, 1}}) {
    const Agreement truth = WarpAgreement(synthetic(), synthetic().truth, i, j);
    const Agreement init = WarpAgreement(synthetic(), synthetic().init, i, j);
    EXPECT_GT(truth.windows, 1000);
    EXPECT_GT(truth.mean_zncc, 0.9);
    EXPECT_LT(init.mean_zncc, truth.mean_zncc - 0.15);
    RecordProperty("truth", std::to_string(truth.mean_zncc));
    RecordProperty("init", std::to_string(init.mean_zncc));
  }
}

TEST_P(SyntheticScenes, EveryViewSeesTheSurfaceInGreyLevelsWithinRange) {
  for (size_t v = 0; v < synthetic().scene.views.size(); ++v) {
    const View& view = synthetic().scene.views[v];
    ASSERT_EQ(view.gray.type(), CV_8UC1);
    EXPECT_EQ(view.gray.size(), cv::Size(view.camera.width, view.camera.height));
    const cv::Mat surface = synthetic().depth[v] > 0;
    const int pixels = cv::countNonZero(surface);
    EXPECT_GT(pixels, 0.25 * static_cast<double>(surface.total()));
    cv::Scalar mean;
    cv::Scalar sigma;
    cv::meanStdDev(view.gray, mean, sigma, surface);
    EXPECT_GT(sigma[0], 10);
    EXPECT_GT(mean[0], 50);
    EXPECT_LT(mean[0], 170);
    const int clipped = cv::countNonZero(surface & ((view.gray == 0) | (view.gray == 255)));
    EXPECT_LT(clipped, 0.001 * pixels);
  }
}

TEST_P(SyntheticScenes, SparsePointsProjectWhereTheDepthMapsSay) {
  const Scene& scene = synthetic().scene;
  EXPECT_EQ(scene.points.size(), 300U);
  int observations = 0;
  int close = 0;
  for (const ScenePoint& point : scene.points) {
    ASSERT_GE(point.views.size(), 2U);
    EXPECT_TRUE(std::is_sorted(point.views.begin(), point.views.end()));
    EXPECT_EQ(std::adjacent_find(point.views.begin(), point.views.end()), point.views.end());
    for (const int v : point.views) {
      const Camera& camera = scene.views[v].camera;
      const Eigen::Vector2d at = camera.Project(point.position);
      if (!camera.Contains(at)) continue;  // the noise may move a point over the rim
      const int col = std::min(static_cast<int>(at.x()), camera.width - 1);
      const int row = std::min(static_cast<int>(at.y()), camera.height - 1);
      // The depths of the surface within a pixel of the point, and the point's own noise.
      double nearest = 1e9;
      double farthest = 0;
      for (int r = std::max(0, row - 1); r <= std::min(camera.height - 1, row + 1); ++r) {
        for (int c = std::max(0, col - 1); c <= std::min(camera.width - 1, col + 1); ++c) {
          const double depth = synthetic().depth[v](r, c);
          if (depth <= 0) continue;
          nearest = std::min(nearest, depth);
          farthest = std::max(farthest, depth);
        }
      }
      const double depth = camera.Depth(point.position);
      const double noise = synthetic().footprint;
      ++observations;
      if (depth > nearest - noise && depth < farthest + noise) ++close;
    }
  }
  EXPECT_GT(observations, 600);
  // Noise moves some points over a rim.
  EXPECT_GT(close, 0.95 * observations);
}

TEST_P(SyntheticScenes, DepthMapsAreThoseOfTheTruthMesh) {
  // Each sampled depth puts a point on the plane of a truth face, checked without the ray caster.
  const Camera& camera = synthetic().scene.views[1].camera;
  const TriangleMesh& truth = synthetic().truth;
  for (const auto& [row, col] : {std::pair<int, int>(60, 80), {40, 90}, {75, 66}, {52, 73}}) {
    const Eigen::Vector3d origin = camera.Center();
    const Eigen::Vector3d direction = camera.Ray(col + 0.5, row + 0.5);
    double nearest = 0;
    for (const Eigen::Vector3i& face : truth.faces) {
      Eigen::Matrix3d system;
      system << truth.vertices[face[1]] - truth.vertices[face[0]],
          truth.vertices[face[2]] - truth.vertices[face[0]], -direction;
      if (std::abs(system.determinant()) < 1e-14) continue;
      const Eigen::Vector3d solution = system.inverse() * (origin - truth.vertices[face[0]]);
      if (solution[0] < 0 || solution[1] < 0 || solution[0] + solution[1] > 1) continue;
      if (solution[2] > 0 && (nearest == 0 || solution[2] < nearest)) nearest = solution[2];
    }
    EXPECT_NEAR(synthetic().depth[1](row, col), nearest, 1e-6);
  }
}

TEST_P(SyntheticScenes, TruthPointsLieOnTheSurfaceThatTwoViewsSee) {
  const MeshRays rays(synthetic().truth);
  ASSERT_EQ(synthetic().truth_points.size(), synthetic().truth_normals.size());
  EXPECT_GT(synthetic().truth_points.size(), 1000U);
  for (size_t p = 0; p < synthetic().truth_points.size(); p += 37) {
    const Eigen::Vector3d& point = synthetic().truth_points[p];
    const Eigen::Vector3d& normal = synthetic().truth_normals[p];
    EXPECT_NEAR(normal.norm(), 1, 1e-9);
    RayHit hit;
    ASSERT_TRUE(rays.Intersect(point + 0.5 * synthetic().footprint * normal, -normal, &hit));
    EXPECT_NEAR(hit.distance, 0.5 * synthetic().footprint, 0.02 * synthetic().footprint);
    int seen = 0;
    for (const View& view : synthetic().scene.views) {
      seen += rays.Sees(view.camera, point, normal) ? 1 : 0;
    }
    EXPECT_GE(seen, 2);
  }
}

TEST(Synthetic, SparsePointsWithoutNoiseLieOnTheSurfaceTheirViewsSee) {
  SyntheticOptions options = SmallOptions(SyntheticKind::kOccluders);
  options.point_noise_px = 0;
  const SyntheticScene synthetic = MakeSyntheticScene(options);
  const MeshRays rays(synthetic.truth);
  for (const ScenePoint& point : synthetic.scene.points) {
    for (const int v : point.views) {
      const Camera& camera = synthetic.scene.views[v].camera;
      RayHit hit;
      ASSERT_TRUE(rays.Intersect(camera.Center(), point.position - camera.Center(), &hit));
      EXPECT_NEAR(hit.distance, 1, 2e-4);
    }
  }
}

TEST(Synthetic, ReliefStartsByTheReliefAwayFromTheTruth) {
  SyntheticOptions options = SmallOptions(SyntheticKind::kRelief);
  options.init_noise_px = 0;
  const SyntheticScene rough = MakeSyntheticScene(options);
  const double difference = RmsDepthDifference(rough, rough.init);
  EXPECT_GT(difference, 3);
  EXPECT_LT(difference, 8);
  options.relief_px = 0;
  options.init_edge_px = 4;
  const SyntheticScene smooth = MakeSyntheticScene(options);
  EXPECT_LT(RmsDepthDifference(smooth, smooth.init), 0.3);
}

TEST(Synthetic, OccludersOccludeAndReliefHardlyDoes) {
  EXPECT_GT(HiddenShare(SmallScene(SyntheticKind::kOccluders), 0, 2), 0.05);
  EXPECT_LT(HiddenShare(SmallScene(SyntheticKind::kRelief), 0, 1), 0.05);
}

TEST(Synthetic, InitialMeshesAreCoarseManifoldAndOrientedAsTheTruth) {
  for (const SyntheticKind kind : kAll) {
    SCOPED_TRACE(NameOf(kind));
    const SyntheticScene& synthetic = SmallScene(kind);
    EXPECT_LT(20 * synthetic.init.faces.size(), synthetic.truth.faces.size());
    const std::vector<char> boundary =
        BoundaryVertices(synthetic.init, VertexFaces(synthetic.init));
    if (kind == SyntheticKind::kScan) {
      EXPECT_EQ(std::count(boundary.begin(), boundary.end(), 1), 0);
    }
    // Seen from the first camera every face of init that is hit first looks at it.
    const MeshRays rays(synthetic.init);
    const Camera& camera = synthetic.scene.views[0].camera;
    int front = 0;
    int back = 0;
    for (int row = 0; row < camera.height; row += 3) {
      for (int col = 0; col < camera.width; col += 3) {
        RayHit hit;
        const Eigen::Vector3d ray = camera.Ray(col + 0.5, row + 0.5);
        if (!rays.Intersect(camera.Center(), ray, &hit)) continue;
        (FaceAreaNormal(synthetic.init, hit.face).dot(ray) < 0 ? front : back) += 1;
      }
    }
    EXPECT_GT(front, 300);
    EXPECT_EQ(back, 0);
  }
}

TEST(Synthetic, ExposureAndNoiseAreAsAsked) {
  SyntheticOptions options = SmallOptions(SyntheticKind::kRelief);
  options.noise_sigma = 0;
  options.exposure_spread = 0;
  const SyntheticScene clean = MakeSyntheticScene(options);
  options.noise_sigma = 3;
  const SyntheticScene noisy = MakeSyntheticScene(options);
  cv::Mat difference;
  cv::subtract(noisy.scene.views[0].gray, clean.scene.views[0].gray, difference, {}, CV_32F);
  cv::Scalar mean;
  cv::Scalar sigma;
  cv::meanStdDev(difference, mean, sigma);
  EXPECT_NEAR(mean[0], 0, 0.1);
  EXPECT_NEAR(sigma[0], 3, 0.15);

  options.noise_sigma = 0;
  options.exposure_spread = 0.1;
  const SyntheticScene exposed = MakeSyntheticScene(options);
  for (int v = 0; v < 3; ++v) {
    const cv::Mat surface = clean.depth[v] > 0;
    const double ratio = cv::mean(exposed.scene.views[v].gray, surface)[0] /
                         cv::mean(clean.scene.views[v].gray, surface)[0];
    EXPECT_GT(std::abs(ratio - 1), 1e-3);
    EXPECT_LT(std::abs(ratio - 1), 0.5);
  }
}

TEST(Synthetic, ScansStandUpright) {
  // A pin on a disc, along each axis in turn: in the scene its tip is always at the top.
  for (const auto& [scan_up, name] : ChoicesOf(SignedAxis())) {
    const std::string up = name;
    SCOPED_TRACE(up);
    SyntheticOptions options = SmallOptions(SyntheticKind::kScan);
    options.scan_up = scan_up;
    options.truth_point_count = 0;
    const double sign = up[0] == '-' ? -1 : 1;
    const int axis = up.back() - 'x';
    TriangleMesh pin = BodyMesh({{1, 1, 1}, 0, true}, 0.3, [](const auto&) { return 0.0; });
    for (Eigen::Vector3d& vertex : pin.vertices) {
      if (sign * vertex[axis] > 0) vertex[axis] *= 3;
    }
    const SyntheticScene synthetic = MakeSyntheticScene(options, pin);
    const auto width_at_top = [&](double from, double to) {
      double width = 0;
      for (const Eigen::Vector3d& vertex : synthetic.truth.vertices) {
        if (vertex.y() > from && vertex.y() < to) width = std::max(width, std::abs(vertex.x()));
      }
      return width;
    };
    EXPECT_LT(width_at_top(0.6, 1.1), 0.7 * width_at_top(-1.1, -0.5));
    // Still turned outward: a reflection would turn it inside out.
    double volume = 0;
    for (size_t f = 0; f < synthetic.truth.faces.size(); ++f) {
      const Eigen::Vector3d normal = FaceAreaNormal(synthetic.truth, static_cast<int>(f));
      volume += normal.dot(synthetic.truth.vertices[synthetic.truth.faces[f][0]]);
    }
    EXPECT_GT(volume, 0);
  }
}

TEST(Synthetic, SmallestSizesWork) {
  const TriangleMesh scan = BodyMesh({{1, 1, 1}, 0.3, false}, 0.3, [](const auto&) { return 0.0; });
  for (const SyntheticKind scene : kAll) {
    SyntheticOptions options = SmallOptions(scene);
    options.width = 16;
    options.height = 16;
    options.views = 1;
    const SyntheticScene one = MakeSyntheticScene(options, scan);
    EXPECT_EQ(one.scene.views.size(), 1U);
    EXPECT_TRUE(one.scene.points.empty());  // nothing is seen twice
    EXPECT_TRUE(one.truth_points.empty());
    options.views = 2;
    options.point_count = 0;
    options.truth_point_count = 0;
    EXPECT_TRUE(MakeSyntheticScene(options, scan).scene.points.empty());
  }
}

TEST(Synthetic, TruthFilesReadBack) {
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / "burin_synthetic_truth";
  std::filesystem::remove_all(folder);
  const SyntheticScene& synthetic = SmallScene(SyntheticKind::kRelief);
  EXPECT_THROW(WriteSyntheticTruth(synthetic, folder), InputError);
  std::filesystem::create_directory(folder);
  WriteSyntheticTruth(synthetic, folder);

  const PointCloud cloud = ReadPointCloud(folder / "truth_points.ply");
  ASSERT_EQ(cloud.points.size(), synthetic.truth_points.size());
  EXPECT_LT((cloud.points.back() - synthetic.truth_points.back()).norm(), 1e-6);
  EXPECT_LT((cloud.normals.back() - synthetic.truth_normals.back()).norm(), 1e-6);
  const cv::Mat depth = cv::imread(folder / "depth" / "view_001.tiff", cv::IMREAD_UNCHANGED);
  ASSERT_EQ(depth.type(), CV_32FC1);
  EXPECT_EQ(cv::countNonZero(depth != synthetic.depth[1]), 0);
  const Scene exact = LoadScene({folder / "true_cameras", {}, {}}, /*with_images=*/false);
  ASSERT_EQ(exact.views.size(), 3U);
  EXPECT_EQ(exact.points.size(), synthetic.scene.points.size());
  for (size_t v = 0; v < 3; ++v) {
    EXPECT_EQ(exact.views[v].name, synthetic.scene.views[v].name);
    EXPECT_LT((exact.views[v].camera.Center() - synthetic.true_cameras[v].Center()).norm(), 1e-6);
  }
  const auto json = nlohmann::json::parse(std::ifstream(folder / "synth.json"));
  EXPECT_EQ(json["options"]["synth.scene"], "relief");
  EXPECT_EQ(json["options"]["synth.views"], 3);
  EXPECT_EQ(json["options"]["synth.noise_sigma"], 1.5);
  EXPECT_EQ(json["footprint"], synthetic.footprint);
  std::filesystem::remove_all(folder);
}

TEST(Synthetic, BadOptionsAreInputErrors) {
  SyntheticOptions options = SmallOptions(SyntheticKind::kRelief);
  options.width = -1;
  EXPECT_THROW(MakeSyntheticScene(options), InputError);
  options = SmallOptions(SyntheticKind::kScan);
  EXPECT_THROW(MakeSyntheticScene(options), InputError);
  TriangleMesh point;
  point.vertices = {{1, 1, 1}};
  point.faces = {{0, 0, 0}};
  EXPECT_THROW(MakeSyntheticScene(options, point), InputError);
}

}  // namespace
}  // namespace burin
