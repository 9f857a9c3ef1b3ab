#include "core/image/noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>

#include "core/support/counter_random.h"

namespace burin {
namespace {

TEST(CounterRandom, UniformAndNormalHaveTheirMoments) {
  const CounterRandom random(5, 9);
  const int count = 200000;
  double uniform = 0;
  double uniform_square = 0;
  double normal = 0;
  double normal_square = 0;
  double normal_fourth = 0;
  for (int k = 0; k < count; ++k) {
    const double u = random.Uniform(k);
    ASSERT_GE(u, 0);
    ASSERT_LT(u, 1);
    uniform += u;
    uniform_square += u * u;
    const double n = random.Normal(k);
    normal += n;
    normal_square += n * n;
    normal_fourth += n * n * n * n;
  }
  EXPECT_NEAR(uniform / count, 0.5, 0.003);
  EXPECT_NEAR(uniform_square / count, 1.0 / 3, 0.003);
  EXPECT_NEAR(normal / count, 0, 0.01);
  EXPECT_NEAR(normal_square / count, 1, 0.02);
  EXPECT_NEAR(normal_fourth / count, 3, 0.15);
}

TEST(CounterRandom, SeedsStreamsAndCountersGiveDifferentNumbers) {
  std::set<std::uint64_t> seen;
  for (int seed = 0; seed < 20; ++seed) {
    for (int stream = 0; stream < 20; ++stream) {
      for (int k = 0; k < 20; ++k) seen.insert(CounterRandom(seed, stream).Bits(k));
    }
  }
  EXPECT_EQ(seen.size(), 8000U);
}

TEST(Noise, GradientNoiseIsContinuousAcrossCellsAndZeroOnTheLattice) {
  EXPECT_EQ(GradientNoise(3, {2, -5, 7}), 0);
  for (double y = 0.05; y < 1; y += 0.1) {
    for (const double face : {-1.0, 0.0, 3.0}) {
      const double below = GradientNoise(3, {face - 1e-6, y, 0.3});
      const double above = GradientNoise(3, {face + 1e-6, y, 0.3});
      EXPECT_NEAR(below, above, 1e-5);
    }
  }
}

TEST(Noise, BandNoiseHasZeroMeanUnitVarianceAndItsWavelength) {
  for (const double wavelength : {0.01, 5.0}) {
    const BandNoise noise(11, wavelength, 4 * wavelength, 0.5);
    const CounterRandom random(1, 1);
    const int count = 200000;
    double sum = 0;
    double square = 0;
    for (int k = 0; k < count; ++k) {
      const double value = noise(1000 * wavelength *
                                 Eigen::Vector3d(random.Uniform(3 * k), random.Uniform(3 * k + 1),
                                                 random.Uniform(3 * k + 2)));
      sum += value;
      square += value * value;
    }
    EXPECT_NEAR(sum / count, 0, 0.02);
    EXPECT_NEAR(square / count, 1, 0.04);  // 2 % of standard deviation
  }
  // Waves of length 1 in all directions of space cross zero 2 / sqrt(3) times per unit of a line.
  const BandNoise single(4, 1, 1, 0);
  int crossings = 0;
  double before = 0;
  for (int k = 0; k < 50000; ++k) {
    const double value = single(k * 0.02 * Eigen::Vector3d(0.6, 0.48, 0.64));
    crossings += before * value < 0 ? 1 : 0;
    before = value;
  }
  EXPECT_NEAR(crossings / 1000.0, 2 / std::sqrt(3.0), 0.06);
}

TEST(Noise, StoneStaysInRangeWithRegionsOfDifferentContrast) {
  const StoneTexture stone(2, 0.01);
  double least = 255;
  double most = 0;
  double least_deviation = 255;
  double most_deviation = 0;
  for (int block = 0; block < 60; ++block) {
    double sum = 0;
    double square = 0;
    const int count = 2000;
    for (int k = 0; k < count; ++k) {
      const double value = stone(Eigen::Vector3d(block + k * 1e-4, k * 7e-5, 0.3));
      least = std::min(least, value);
      most = std::max(most, value);
      sum += value;
      square += value * value;
    }
    const double deviation = std::sqrt(square / count - sum * sum / count / count);
    least_deviation = std::min(least_deviation, deviation);
    most_deviation = std::max(most_deviation, deviation);
  }
  EXPECT_GT(least, 25);
  EXPECT_LT(most, 215);
  EXPECT_GT(least_deviation, 5);
  EXPECT_GT(most_deviation, 2 * least_deviation);
}

}  // namespace
}  // namespace burin
