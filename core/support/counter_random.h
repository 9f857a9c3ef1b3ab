// Random numbers as a function of (seed, stream, counter): no state, so that parallel work draws
// the same numbers in any order, and no standard distributions, whose results differ between
// standard libraries.
#pragma once

#include <cmath>
#include <cstdint>

namespace burin {

// A bijection of 64 bits in which every input bit changes every output bit with probability about
// 1/2 (the finaliser of SplitMix64: Steele, Lea, Flood 2014).
inline std::uint64_t MixBits(std::uint64_t bits) {
  bits = (bits ^ (bits >> 30)) * 0xBF58476D1CE4E5B9U;
  bits = (bits ^ (bits >> 27)) * 0x94D049BB133111EBU;
  return bits ^ (bits >> 31);
}

class CounterRandom {
 public:
  // Different streams of one seed are independent.
  CounterRandom(std::uint64_t seed, std::uint64_t stream)
      : key_(MixBits(MixBits(seed + 0x9E3779B97F4A7C15U) ^ (stream * 0xD1B54A32D192ED03U))) {}

  std::uint64_t Bits(std::uint64_t counter) const {
    return MixBits(key_ + (counter + 1) * 0x9E3779B97F4A7C15U);
  }

  // In [0, 1), multiples of 2^-53.
  double Uniform(std::uint64_t counter) const {
    return static_cast<double>(Bits(counter) >> 11) * 0x1p-53;
  }

  // Standard normal by Box and Muller; uses the uniform numbers 2*counter and 2*counter + 1.
  double Normal(std::uint64_t counter) const {
    constexpr double kTwoPi = 6.283185307179586;
    return std::sqrt(-2 * std::log(1 - Uniform(2 * counter))) *
           std::cos(kTwoPi * Uniform(2 * counter + 1));
  }

 private:
  std::uint64_t key_;
};

}  // namespace burin
