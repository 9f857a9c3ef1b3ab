#include "core/visibility/seen_points.h"

#include <gtest/gtest.h>

#include "core/support/parallel.h"
#include "tests/test_scene.h"
#include "tests/test_shapes.h"

namespace burin {
namespace {

// One pixel of 400 x 300 is 0.01 wide on the plane z = 0, which fills the image.
View Front() {
  View view;
  view.camera = test::LookAt({0, 0, 4}, {0, 0, 0}, 400, 300, 400);
  return view;
}

TriangleMesh Wall(double z, double half) {
  TriangleMesh mesh = Plane(z, 2 * half);
  for (Eigen::Vector3d& vertex : mesh.vertices) vertex -= Eigen::Vector3d(half, half, 0);
  return mesh;
}

TEST(SeenPoints, AreAGridOfPixelCentresOnTheSurface) {
  const View view = Front();
  const std::vector<Eigen::Vector3d> points = SeenPoints(Wall(0, 5), {view}, 1200)[0];
  EXPECT_EQ(points.size(), 1200U);
  for (const Eigen::Vector3d& point : points) {
    EXPECT_NEAR(point.z(), 0, 1e-9);
    const Eigen::Vector2d pixel = view.camera.Project(point);
    EXPECT_NEAR(pixel.x() - std::floor(pixel.x()), 0.5, 1e-4);
    EXPECT_NEAR(pixel.y() - std::floor(pixel.y()), 0.5, 1e-4);
  }
  // Ten pixels apart along rows and columns.
  EXPECT_NEAR((view.camera.Project(points[1]) - view.camera.Project(points[0])).norm(), 10, 1e-4);
  EXPECT_NEAR((view.camera.Project(points[40]) - view.camera.Project(points[0])).norm(), 10, 1e-4);
}

TEST(SeenPoints, AreNeverMoreThanAskedFor) {
  View view = Front();
  for (const int count : {1, 2, 7, 1000, 1500, 200000}) {
    const size_t found = SeenPoints(Wall(0, 5), {view}, count)[0].size();
    EXPECT_LE(found, static_cast<size_t>(count));
    EXPECT_GE(found, static_cast<size_t>(std::min(count, 400 * 300) * 0.4)) << count;
  }
  view.camera = test::LookAt({0, 0, 4}, {0, 0, 0}, 4000, 3, 400);
  EXPECT_LE(SeenPoints(Wall(0, 50), {view}, 100)[0].size(), 100U);
  EXPECT_TRUE(SeenPoints(Wall(0, 5), {view}, 0)[0].empty());
}

TEST(SeenPoints, LeaveOutWhatTheMaskLeavesOut) {
  View view = Front();
  view.mask = cv::Mat::zeros(300, 400, CV_8UC1);
  view.mask.colRange(0, 200).setTo(255);
  const std::vector<Eigen::Vector3d> points = SeenPoints(Wall(0, 5), {view}, 1200)[0];
  EXPECT_EQ(points.size(), 600U);
  for (const Eigen::Vector3d& point : points) EXPECT_LT(view.camera.Project(point).x(), 200);
}

TEST(SeenPoints, AreOnTheFirstSurfaceBeyondTheNearDepth) {
  TriangleMesh mesh = Wall(0, 5);
  const TriangleMesh before = Wall(2, 5);
  for (const Eigen::Vector3i& face : before.faces) {
    mesh.faces.push_back(face + Eigen::Vector3i::Constant(static_cast<int>(mesh.vertices.size())));
  }
  mesh.vertices.insert(mesh.vertices.end(), before.vertices.begin(), before.vertices.end());
  View view = Front();
  const std::vector<Eigen::Vector3d> nearest = SeenPoints(mesh, {view})[0];
  EXPECT_FALSE(nearest.empty());
  for (const Eigen::Vector3d& point : nearest) EXPECT_NEAR(point.z(), 2, 1e-9);
  view.camera.near_depth = 3;
  const std::vector<Eigen::Vector3d> beyond = SeenPoints(mesh, {view})[0];
  EXPECT_FALSE(beyond.empty());
  for (const Eigen::Vector3d& point : beyond) EXPECT_NEAR(point.z(), 0, 1e-9);
}

TEST(SeenPoints, AreNoneFromBehindOrBeside) {
  View behind = Front();
  behind.camera = test::LookAt({0, 0, -4}, {0, 0, 0}, 400, 300, 400);
  View away = Front();
  away.camera = test::LookAt({0, 0, 4}, {0, 0, 8}, 400, 300, 400);
  const auto points = SeenPoints(Wall(0, 5), {behind, away, Front()});
  EXPECT_TRUE(points[0].empty());
  EXPECT_TRUE(points[1].empty());
  EXPECT_FALSE(points[2].empty());
  EXPECT_TRUE(SeenPoints(TriangleMesh(), {Front()})[0].empty());
}

TEST(SeenPoints, DoNotDependOnThreads) {
  const std::vector<View> views(5, Front());
  const auto all = SeenPoints(Relief(40), views);
  const ThreadScope one(1);
  EXPECT_EQ(SeenPoints(Relief(40), views), all);
}

}  // namespace
}  // namespace burin
