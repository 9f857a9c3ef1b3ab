// Cameras compared in pixels where the surface is: what a similarity of the world explains counts for nothing.
#include "core/scene/camera_similarity.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/support/counter_random.h"
#include "core/synthetic/synthetic_stress.h"
#include "tests/test_scene.h"

namespace burin {
namespace {

using Points = std::vector<std::vector<Eigen::Vector3d>>;

Similarity Known() {
  Similarity motion;
  motion.scale = 2.5;
  motion.rotation = Eigen::AngleAxisd(2.0, Eigen::Vector3d(1, -2, 3).normalized()).matrix();
  motion.translation = {10, -20, 5};
  return motion;
}

std::vector<Camera> Orbit(int count) {
  std::vector<Camera> cameras;
  for (int k = 0; k < count; ++k) {
    const double angle = 0.5 * k;
    cameras.push_back(test::LookAt({4 * std::sin(angle), 0.3 * k, 4 * std::cos(angle)}, {0, 0, 0},
                                   400, 300, 450));
  }
  return cameras;
}

Points SurfacePoints(size_t views, int count) {
  test::Random random(3);
  Points points(views);
  for (std::vector<Eigen::Vector3d>& of_view : points) {
    for (int k = 0; k < count; ++k) of_view.push_back(random.Vector());
  }
  return points;
}

std::vector<Camera> AllMoved(std::vector<Camera> cameras, const Similarity& motion) {
  for (Camera& camera : cameras) camera = Moved(camera, motion);
  return cameras;
}

std::vector<Camera> Noisy(std::vector<Camera> cameras, double px) {
  const CounterRandom random(5, 0);
  for (size_t v = 0; v < cameras.size(); ++v) {
    cameras[v] = WithPoseNoise(cameras[v], px, random, static_cast<int>(v));
  }
  return cameras;
}

CameraSimilarity Fit(const std::vector<Camera>& first, const std::vector<Camera>& second,
                     const Points& points) {
  CameraSimilarity fit;
  std::string error;
  EXPECT_TRUE(FitCameraSimilarity(first, second, points, &fit, &error)) << error;
  return fit;
}

void ExpectNear(const Similarity& a, const Similarity& b, double tolerance) {
  EXPECT_NEAR(a.scale, b.scale, tolerance);
  EXPECT_LE((a.rotation - b.rotation).norm(), tolerance);
  EXPECT_LE((a.translation - b.translation).norm(), tolerance);
}

TEST(CameraSimilarity, AMovedCameraSeesTheMovedWorldAsBefore) {
  Camera camera = Orbit(2)[1];
  camera.near_depth = 0.5;
  const Camera moved = Moved(camera, Known());
  test::Random random(1);
  for (int k = 0; k < 20; ++k) {
    const Eigen::Vector3d point = random.Vector();
    EXPECT_LT((moved.Project(Known() * point) - camera.Project(point)).norm(), 1e-10);
    EXPECT_NEAR(moved.Depth(Known() * point), 2.5 * camera.Depth(point), 1e-10);
  }
  EXPECT_NEAR(moved.near_depth, 1.25, 1e-12);
  EXPECT_LT((moved.Center() - Known() * camera.Center()).norm(), 1e-10);
}

TEST(CameraSimilarity, RecoversAKnownSimilarity) {
  const std::vector<Camera> cameras = Orbit(7);
  const Points points = SurfacePoints(7, 30);
  const CameraSimilarity fit = Fit(cameras, AllMoved(cameras, Known()), points);
  ExpectNear(fit.second_from_first, Known(), 1e-10);
  EXPECT_LT(fit.errors.rms_px, 1e-9);
  EXPECT_EQ(fit.errors.views, 7);
}

TEST(CameraSimilarity, SameCamerasAreLeftAlone) {
  const std::vector<Camera> cameras = Orbit(5);
  const CameraSimilarity fit = Fit(cameras, cameras, SurfacePoints(5, 30));
  ExpectNear(fit.second_from_first, Similarity(), 0);
  EXPECT_EQ(fit.errors.rms_px, 0);
  EXPECT_EQ(fit.iterations, 0);
}

// The error does not change when either world is moved, and the similarity goes along.
TEST(CameraSimilarity, DoesNotDependOnTheFrames) {
  const std::vector<Camera> cameras = Orbit(7);
  const std::vector<Camera> noisy = Noisy(cameras, 2);
  const Points points = SurfacePoints(7, 60);
  const CameraSimilarity fit = Fit(cameras, noisy, points);
  EXPECT_GT(fit.errors.rms_px, 0.5);

  const CameraSimilarity second_moved = Fit(cameras, AllMoved(noisy, Known()), points);
  ExpectNear(second_moved.second_from_first, Known() * fit.second_from_first, 1e-6);
  EXPECT_NEAR(second_moved.errors.rms_px, fit.errors.rms_px, 1e-9);

  Points moved_points = points;
  for (std::vector<Eigen::Vector3d>& of_view : moved_points) {
    for (Eigen::Vector3d& point : of_view) point = Known() * point;
  }
  const CameraSimilarity first_moved = Fit(AllMoved(cameras, Known()), noisy, moved_points);
  EXPECT_NEAR(first_moved.errors.rms_px, fit.errors.rms_px, 1e-9);
  for (size_t v = 0; v < cameras.size(); ++v) {
    EXPECT_NEAR(first_moved.errors.view_px[v], fit.errors.view_px[v], 1e-6);
  }
}

// Seven directions, both ways: E rises by the square of the way.
TEST(CameraSimilarity, IsAMinimum) {
  const std::vector<Camera> cameras = Orbit(7);
  const std::vector<Camera> noisy = Noisy(cameras, 2);
  const Points points = SurfacePoints(7, 60);
  const CameraSimilarity fit = Fit(cameras, noisy, points);
  EXPECT_LT(fit.errors.rms_px, MeasureCameraErrors(noisy, SightingsOf(cameras, points), {}).rms_px);
  const double least = std::pow(fit.errors.rms_px, 2);
  for (int k = 0; k < 7; ++k) {
    double rise[2];
    for (const int sign : {-1, 1}) {
      Similarity small;
      const double step = sign * 1e-3;
      const Eigen::Vector3d axis = Eigen::Vector3d::Unit(k % 3);
      if (k < 3) small.rotation = Eigen::AngleAxisd(step, axis).matrix();
      if (k >= 3 && k < 6) small.translation = step * axis;
      if (k == 6) small.scale = 1 + step;
      const CameraErrors errors =
          MeasureCameraErrors(noisy, SightingsOf(cameras, points), small * fit.second_from_first);
      rise[(sign + 1) / 2] = std::pow(errors.rms_px, 2) - least;
      EXPECT_GT(rise[(sign + 1) / 2], 0) << k;
    }
    EXPECT_NEAR(rise[0], rise[1], 0.02 * rise[1]) << k;
  }
}

TEST(CameraSimilarity, CountsEveryViewAlike) {
  const std::vector<Camera> cameras = Orbit(3);
  std::vector<Camera> shifted = cameras;
  shifted[1].cx += 3;
  Points points = SurfacePoints(3, 10);
  points[0].resize(2);
  const CameraErrors errors = MeasureCameraErrors(shifted, SightingsOf(cameras, points), {});
  EXPECT_EQ(errors.view_px[0], 0);
  EXPECT_NEAR(errors.view_px[1], 3, 1e-9);
  EXPECT_NEAR(errors.rms_px, std::sqrt(3.0), 1e-9);
}

TEST(CameraSimilarity, AViewWithoutPointsDoesNotCount) {
  std::vector<Camera> first = Orbit(7);
  std::vector<Camera> second = Noisy(first, 1);
  Points points = SurfacePoints(7, 40);
  points[2].clear();
  const CameraSimilarity with = Fit(first, second, points);
  EXPECT_TRUE(std::isnan(with.errors.view_px[2]));
  EXPECT_EQ(with.errors.views, 6);
  first.erase(first.begin() + 2);
  second.erase(second.begin() + 2);
  points.erase(points.begin() + 2);
  const CameraSimilarity without = Fit(first, second, points);
  ExpectNear(with.second_from_first, without.second_from_first, 0);
  EXPECT_EQ(with.errors.rms_px, without.errors.rms_px);
}

// Its size is open: it stays, and the view is met exactly.
TEST(CameraSimilarity, OneViewIsMetExactlyAndKeepsItsSize) {
  const std::vector<Camera> one = Orbit(1);
  Similarity motion = Known();
  motion.scale = 1;
  const CameraSimilarity fit = Fit(one, AllMoved(one, motion), SurfacePoints(1, 20));
  EXPECT_NEAR(fit.second_from_first.scale, 1, 1e-9);
  EXPECT_LT(fit.errors.rms_px, 1e-9);
}

TEST(CameraSimilarity, NeedsThreePoints) {
  const std::vector<Camera> cameras = Orbit(3);
  CameraSimilarity fit;
  std::string error;
  Points points(3);
  EXPECT_FALSE(FitCameraSimilarity(cameras, cameras, points, &fit, &error));
  EXPECT_EQ(error, "camera similarity: 0 surface points in 3 views, at least 3 needed");
  points[1] = {{0, 0, 0}, {0.1, 0, 0}};
  EXPECT_FALSE(FitCameraSimilarity(cameras, Noisy(cameras, 1), points, &fit, &error));
  ExpectNear(fit.second_from_first, Similarity(), 0);
  points[1].emplace_back(0, 0.1, 0);
  EXPECT_TRUE(FitCameraSimilarity(cameras, Noisy(cameras, 1), points, &fit, &error));
  EXPECT_LT(fit.errors.rms_px, 1e-6);
}

TEST(CameraSimilarity, APointBehindTheCameraCountsAsTheDiagonal) {
  const std::vector<Camera> cameras = Orbit(4);
  std::vector<Camera> turned = cameras;
  const Eigen::Vector3d center = turned[3].Center();
  turned[3].rotation = Eigen::Vector3d(-1, 1, -1).asDiagonal() * turned[3].rotation;
  turned[3].translation = -turned[3].rotation * center;
  const CameraErrors errors =
      MeasureCameraErrors(turned, SightingsOf(cameras, SurfacePoints(4, 10)), {});
  EXPECT_EQ(errors.behind[3], 10);
  EXPECT_NEAR(errors.view_px[3], 500, 1e-9);
  EXPECT_EQ(errors.behind[0], 0);
}

}  // namespace
}  // namespace burin
