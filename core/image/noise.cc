#include "core/image/noise.h"

#include <glog/logging.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/support/counter_random.h"

namespace burin {
namespace {

// Standard deviation of GradientNoise over space (measured; noise_test holds it to 2 %).
constexpr double kGradientNoiseSigma = 0.286;

// Lattice cell over wavelength: gives a line the zero crossings of isotropic waves (noise_test).
constexpr double kCellPerWavelength = 0.70;

constexpr std::uint32_t kPrimeX = 0x8DA6B343U;
constexpr std::uint32_t kPrimeY = 0xD8163841U;
constexpr std::uint32_t kPrimeZ = 0xCB1AB31FU;

std::uint32_t MixBits32(std::uint32_t bits) {
  bits = (bits ^ (bits >> 15)) * 0x85EBCA6BU;
  return bits ^ (bits >> 13);
}

// Floor without the library call that a baseline x86-64 needs for std::floor.
std::int32_t Floor(double value) {
  const auto truncated = static_cast<std::int32_t>(value);
  return truncated - (value < truncated ? 1 : 0);
}

// A gradient component in (-1.5, 1.5) from the low ten bits.
float Component(std::uint32_t bits) {
  return (static_cast<float>(static_cast<std::int32_t>(bits & 1023U)) - 511.5F) * (1.5F / 512);
}

float Fade(float t) { return t * t * t * (t * (t * 6 - 15) + 10); }

float Mix(float a, float b, float t) { return a + t * (b - a); }

}  // namespace

double GradientNoise(std::uint32_t seed, const Eigen::Vector3d& point) {
  const std::int32_t ix = Floor(point.x());
  const std::int32_t iy = Floor(point.y());
  const std::int32_t iz = Floor(point.z());
  const auto x = static_cast<float>(point.x() - ix);
  const auto y = static_cast<float>(point.y() - iy);
  const auto z = static_cast<float>(point.z() - iz);
  // Plain arrays over the corners: the compiler turns each loop into vector instructions.
  std::uint32_t hash[8];
  const std::uint32_t hash_x = static_cast<std::uint32_t>(ix) * kPrimeX;
  const std::uint32_t hash_y = static_cast<std::uint32_t>(iy) * kPrimeY;
  const std::uint32_t hash_z = (static_cast<std::uint32_t>(iz) * kPrimeZ) ^ seed;
  const std::uint32_t hash_z1 = ((static_cast<std::uint32_t>(iz) + 1) * kPrimeZ) ^ seed;
  hash[0] = hash_x ^ hash_y;
  hash[1] = (hash_x + kPrimeX) ^ hash_y;
  hash[2] = hash_x ^ (hash_y + kPrimeY);
  hash[3] = (hash_x + kPrimeX) ^ (hash_y + kPrimeY);
  for (int c = 0; c < 4; ++c) {
    hash[c + 4] = hash[c] ^ hash_z1;
    hash[c] ^= hash_z;
  }
  float corner[8];
  for (int c = 0; c < 8; ++c) {
    const std::uint32_t bits = MixBits32(hash[c]);
    const float gradient_x = Component(bits);
    const float gradient_y = Component(bits >> 10);
    const float gradient_z = Component(bits >> 20);
    corner[c] = gradient_x * (x - static_cast<float>(c & 1)) +
                gradient_y * (y - static_cast<float>((c >> 1) & 1)) +
                gradient_z * (z - static_cast<float>(c >> 2));
  }
  const float u = Fade(x);
  const float v = Fade(y);
  const float low = Mix(Mix(corner[0], corner[1], u), Mix(corner[2], corner[3], u), v);
  const float high = Mix(Mix(corner[4], corner[5], u), Mix(corner[6], corner[7], u), v);
  return Mix(low, high, Fade(z));
}

BandNoise::BandNoise(std::uint64_t seed, double finest_wavelength, double coarsest_wavelength,
                     double exponent) {
  CHECK_GT(finest_wavelength, 0);
  CHECK_GE(coarsest_wavelength, finest_wavelength);
  const CounterRandom random(seed, 0x6E6F697365U);
  double variance = 0;
  double wavelength = finest_wavelength;
  for (std::uint64_t k = 0; wavelength <= coarsest_wavelength * (1 + 1e-9); ++k, wavelength *= 2) {
    Octave octave;
    const Eigen::Quaterniond rotation =
        Eigen::Quaterniond(random.Normal(8 * k), random.Normal(8 * k + 1), random.Normal(8 * k + 2),
                           random.Normal(8 * k + 3))
            .normalized();
    octave.lattice_from_world = rotation.toRotationMatrix() / (kCellPerWavelength * wavelength);
    // Numbers from the upper half of the counters, clear of those that the normals use.
    for (int axis = 0; axis < 3; ++axis) {
      octave.offset[axis] = 256 * random.Uniform((1U << 20) + 4 * k + axis);
    }
    octave.seed = static_cast<std::uint32_t>(random.Bits((1U << 20) + 4 * k + 3));
    octave.amplitude = std::pow(wavelength / finest_wavelength, exponent);
    variance += octave.amplitude * octave.amplitude;
    octaves_.push_back(octave);
  }
  for (Octave& octave : octaves_) octave.amplitude /= kGradientNoiseSigma * std::sqrt(variance);
}

double BandNoise::operator()(const Eigen::Vector3d& point) const {
  double sum = 0;
  for (const Octave& octave : octaves_) {
    sum += octave.amplitude *
           GradientNoise(octave.seed, octave.lattice_from_world * point + octave.offset);
  }
  return sum;
}

StoneTexture::StoneTexture(std::uint64_t seed, double finest_wavelength)
    : grain_(MixBits(seed + 1), finest_wavelength, 16 * finest_wavelength, 0.0),
      contrast_(MixBits(seed + 2), 60 * finest_wavelength, 60 * finest_wavelength, 0.0) {}

double StoneTexture::operator()(const Eigen::Vector3d& point) const {
  // Contrast 10 to 40 grey levels of standard deviation; tanh keeps the rare extremes in range.
  const double sigma = 20 * std::exp2(std::tanh(contrast_(point)));
  return 120 + 95 * std::tanh(sigma / 95 * grain_(point));
}

}  // namespace burin
