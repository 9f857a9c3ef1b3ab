#include "core/mesh/closest_point.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/mesh/surface_samples.h"
#include "tests/test_shapes.h"

namespace burin {
namespace {

TEST(SurfaceSamples, AreUniformOverTheArea) {
  // One face has 1/9 of the area of the other: shares follow the area, not the face count.
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 0, 0}, {8, 0, 0}, {5, 3, 0}};
  mesh.faces = {{0, 1, 2}, {1, 1, 2}, {3, 4, 5}};
  const int count = 10000;
  const SurfaceSamples samples = SampleSurface(mesh, count);
  ASSERT_EQ(samples.points.size(), size_t{count});
  EXPECT_NEAR(std::count(samples.faces.begin(), samples.faces.end(), 0), count / 10, 1);
  EXPECT_EQ(std::count(samples.faces.begin(), samples.faces.end(), 1), 0);

  // Within a face: every cell of a 10 x 10 grid over a plane gets its share.
  const SurfaceSamples plane = SampleSurface(Plane(0, 1.0, 3), 100000, 5);
  int in_cell[10][10] = {};
  for (const Eigen::Vector3d& point : plane.points) {
    ASSERT_TRUE(point.x() >= 0 && point.x() <= 1 && point.y() >= 0 && point.y() <= 1);
    ++in_cell[std::min(9, static_cast<int>(point.x() * 10))]
             [std::min(9, static_cast<int>(point.y() * 10))];
  }
  for (const auto& row : in_cell) {
    for (const int n : row) EXPECT_NEAR(n, 1000, 30);  // random points: standard deviation 31
  }
}

TEST(SurfaceSamples, SameSeedSamePoints) {
  const SurfaceSamples first = SampleSurface(Relief(10), 1000, 3);
  EXPECT_EQ(first.points, SampleSurface(Relief(10), 1000, 3).points);
  EXPECT_NE(first.points, SampleSurface(Relief(10), 1000, 4).points);
  EXPECT_TRUE(SampleSurface(TriangleMesh(), 10).points.empty());
}

TEST(MeshDistance, AgreesWithBruteForceAndGivesSides) {
  const TriangleMesh sphere = Sphere(1.0, 2);
  const MeshDistance distance(sphere);
  const SurfaceSamples queries = SampleSurface(Sphere(1.7, 1), 300);
  for (int k = 0; k < 300; ++k) {
    const Eigen::Vector3d query = queries.points[k] * (k % 3 == 0 ? 0.3 : 1.0);
    double nearest = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3i& f : sphere.faces) {  // dense points on each face
      for (int i = 0; i <= 40; ++i) {
        for (int j = 0; j <= 40 - i; ++j) {
          const Eigen::Vector3d point = (i * sphere.vertices[f[0]] + j * sphere.vertices[f[1]] +
                                         (40 - i - j) * sphere.vertices[f[2]]) /
                                        40;
          nearest = std::min(nearest, (point - query).norm());
        }
      }
    }
    const SurfacePoint found = distance.Find(query);
    ASSERT_GE(found.face, 0);
    EXPECT_LE(found.distance, nearest + 1e-12);
    EXPECT_NEAR(found.distance, nearest, 2e-3);
    EXPECT_NEAR((query - found.point).norm(), found.distance, 1e-12);
    EXPECT_EQ(found.SignedDistance(query) > 0, k % 3 != 0);
  }
}

TEST(MeshDistance, CornersEdgesAndDegenerateFaces) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {5, 5, 5}};
  mesh.faces = {{0, 1, 2}, {3, 3, 3}, {3, 3, 0}};
  const MeshDistance distance(mesh);
  EXPECT_DOUBLE_EQ(distance.Find({-3, -4, 0}).distance, 5);
  EXPECT_DOUBLE_EQ(distance.Find({0.5, 0.5, -2}).distance, 2);
  EXPECT_DOUBLE_EQ(distance.Find({2, 2, 0}).distance, std::sqrt(2.0));
  EXPECT_DOUBLE_EQ(distance.Find({6, 5, 5}).distance, 1);
  EXPECT_EQ(distance.Find({6, 5, 5}, 0.5).face, -1);
  EXPECT_EQ(distance.Find({0.5, 0.5, -2}, 2.0).face, 0);
  EXPECT_EQ(distance.Find({0, 0, std::nan("")}).face, -1);
  EXPECT_EQ(MeshDistance(TriangleMesh()).Find({0, 0, 0}).face, -1);
}

TEST(MeshDistance, KeepsItsDigitsFarFromTheOrigin) {
  const Eigen::Vector3d far(4.0e5, 5.0e6, 300);
  TriangleMesh mesh = Plane(0);
  for (Eigen::Vector3d& vertex : mesh.vertices) vertex += far;
  const MeshDistance distance(mesh);
  EXPECT_NEAR(distance.Find(far + Eigen::Vector3d(0.3, 0.4, 0.001)).distance, 0.001, 1e-9);
}

TEST(CloudDistance, FindsTheNearest) {
  const SurfaceSamples samples = SampleSurface(Sphere(1.0, 2), 2000);
  const CloudDistance cloud(samples.points);
  for (int k = 0; k < 200; ++k) {
    const Eigen::Vector3d query = samples.points[k] * 1.3 + Eigen::Vector3d(0.05, -0.1, 0.02);
    double nearest = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3d& p : samples.points) nearest = std::min(nearest, (p - query).norm());
    double found = 0;
    const int index = cloud.Find(query, 10, &found);
    ASSERT_GE(index, 0);
    EXPECT_DOUBLE_EQ(found, nearest);
    EXPECT_DOUBLE_EQ((samples.points[index] - query).norm(), nearest);
    EXPECT_EQ(cloud.Find(query, 0.999 * nearest), -1);
  }
}

}  // namespace
}  // namespace burin
