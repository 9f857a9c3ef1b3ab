// Similarities: their algebra, Umeyama's closed form, and the fit of points to a surface.
#include "core/mesh/alignment.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "tests/test_scene.h"

namespace burin {
namespace {

Similarity Known() {
  Similarity motion;
  motion.scale = 2.5;
  motion.rotation = Eigen::AngleAxisd(2.0, Eigen::Vector3d(1, -2, 3).normalized()).matrix();
  motion.translation = {10, -20, 5};
  return motion;
}

std::vector<Eigen::Vector3d> RandomPoints(int count) {
  test::Random random(3);
  std::vector<Eigen::Vector3d> points;
  points.reserve(count);
  for (int k = 0; k < count; ++k) points.push_back(random.Vector());
  return points;
}

std::vector<Eigen::Vector3d> MovedPoints(const std::vector<Eigen::Vector3d>& points,
                                         const Similarity& motion) {
  std::vector<Eigen::Vector3d> moved;
  moved.reserve(points.size());
  for (const Eigen::Vector3d& point : points) moved.push_back(motion * point);
  return moved;
}

void ExpectNear(const Similarity& a, const Similarity& b, double tolerance) {
  EXPECT_NEAR(a.scale, b.scale, tolerance);
  EXPECT_LT((a.rotation - b.rotation).norm(), tolerance);
  EXPECT_LT((a.translation - b.translation).norm(), tolerance);
}

TEST(Similarity, InverseAndProductAreThoseOfMaps) {
  const Similarity a = Known();
  Similarity b;
  b.scale = 0.3;
  b.rotation = Eigen::AngleAxisd(-0.7, Eigen::Vector3d::UnitY()).matrix();
  b.translation = {1, 2, 3};
  const Eigen::Vector3d x(0.3, -0.8, 1.7);
  EXPECT_LT(((a * b) * x - a * (b * x)).norm(), 1e-13);
  EXPECT_LT((a.Inverse() * (a * x) - x).norm(), 1e-13);
  EXPECT_NEAR(a.AngleDeg(), 2.0 * 180 / M_PI, 1e-10);
}

TEST(FitSimilarity, RecoversAKnownTransform) {
  const std::vector<Eigen::Vector3d> source = RandomPoints(20);
  Similarity fit;
  std::string error;
  ASSERT_TRUE(FitSimilarity(source, MovedPoints(source, Known()), &fit, &error)) << error;
  ExpectNear(fit, Known(), 1e-12);
}

TEST(FitSimilarity, ThreePointsSuffice) {
  const std::vector<Eigen::Vector3d> source = RandomPoints(3);
  Similarity fit;
  std::string error;
  ASSERT_TRUE(FitSimilarity(source, MovedPoints(source, Known()), &fit, &error)) << error;
  ExpectNear(fit, Known(), 1e-11);
}

// The best orthogonal map of a mirrored pattern is a reflection, which no motion is.
TEST(FitSimilarity, IsNeverAReflection) {
  const std::vector<Eigen::Vector3d> source = RandomPoints(20);
  std::vector<Eigen::Vector3d> target = source;
  for (Eigen::Vector3d& point : target) point.x() = -point.x();
  Similarity fit;
  std::string error;
  ASSERT_TRUE(FitSimilarity(source, target, &fit, &error)) << error;
  EXPECT_NEAR(fit.rotation.determinant(), 1, 1e-12);
  EXPECT_GT(fit.scale, 0);
  EXPECT_LT(fit.scale, 0.99);
}

// No nearby similarity has a smaller sum of squares: the gradient at the fit is zero.
TEST(FitSimilarity, MinimisesTheSumOfSquares) {
  const std::vector<Eigen::Vector3d> source = RandomPoints(20);
  std::vector<Eigen::Vector3d> target = MovedPoints(source, Known());
  test::Random random(9);
  for (Eigen::Vector3d& point : target) point += 0.3 * random.Vector();
  Similarity fit;
  std::string error;
  ASSERT_TRUE(FitSimilarity(source, target, &fit, &error)) << error;
  const auto energy = [&](const Similarity& motion) {
    double sum = 0;
    for (size_t k = 0; k < source.size(); ++k)
      sum += (motion * source[k] - target[k]).squaredNorm();
    return sum;
  };
  const double h = 1e-4;
  for (int unknown = 0; unknown < 7; ++unknown) {
    double values[2];
    for (const int side : {0, 1}) {
      const double step = side == 0 ? -h : h;
      Similarity moved = fit;
      if (unknown < 3) {
        moved.rotation =
            Eigen::AngleAxisd(step, Eigen::Vector3d::Unit(unknown)).matrix() * fit.rotation;
      } else if (unknown < 6) {
        moved.translation[unknown - 3] += step;
      } else {
        moved.scale += step;
      }
      values[side] = energy(moved);
      EXPECT_GT(values[side], energy(fit));
    }
    EXPECT_LT(std::abs(values[1] - values[0]) / (2 * h), 1e-6);
  }
}

TEST(FitSimilarity, OpenRotationsAreRefused) {
  Similarity fit;
  std::string error;
  std::vector<Eigen::Vector3d> line;
  line.reserve(5);
  for (int k = 0; k < 5; ++k) line.emplace_back(k, 2 * k, -k);
  EXPECT_FALSE(FitSimilarity(line, line, &fit, &error));
  EXPECT_NE(error.find("line"), std::string::npos);
  line.resize(2);
  EXPECT_FALSE(FitSimilarity(line, line, &fit, &error));
  EXPECT_NE(error.find("2 pairs"), std::string::npos);
}

// The nearest point of a sphere is known in closed form; its turning is free and must be left alone.
TEST(AlignToSurface, GrowsASphereOntoAnother) {
  std::vector<Eigen::Vector3d> points = RandomPoints(500);
  for (Eigen::Vector3d& point : points) point = point.normalized() + Eigen::Vector3d(0.1, 0, 0.05);
  const PlaneOf onto_radius_two = [](int, const Eigen::Vector3d& point,
                                     Eigen::Vector3d* counterpart, Eigen::Vector3d* normal) {
    *normal = point.normalized();
    *counterpart = 2 * *normal;
    return true;
  };
  AlignmentOptions options;
  options.scale = true;
  Alignment alignment;
  std::string error;
  ASSERT_TRUE(AlignToSurface(points, onto_radius_two, options, &alignment, &error)) << error;
  EXPECT_TRUE(alignment.converged);
  EXPECT_NEAR(alignment.motion.scale, 2, 1e-9);
  EXPECT_LT((alignment.motion * Eigen::Vector3d(0.1, 0, 0.05)).norm(), 1e-9);
  EXPECT_LT(alignment.motion.AngleDeg(), 5);
  options.scale = false;
  ASSERT_TRUE(AlignToSurface(points, onto_radius_two, options, &alignment, &error)) << error;
  EXPECT_EQ(alignment.motion.scale, 1);
}

}  // namespace
}  // namespace burin
