// Procedural noise in space: relief and surface texture of the synthetic scenes. These are smooth
// functions of position, so that a surface point has the same colour in every view.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace burin {

// Gradient noise (Perlin 2002) on the unit lattice, with gradients hashed from a cube instead of
// picked from a table: twice continuously differentiable (in single precision), zero at lattice
// points, standard deviation about 0.29. |coordinates| < 2^31.
double GradientNoise(std::uint32_t seed, const Eigen::Vector3d& point);

// Sum of octaves of gradient noise: zero mean and unit variance over space. Every octave has its
// own rotation and offset, so that no plane through the origin meets the lattices specially.
class BandNoise {
 public:
  // Wavelengths finest, 2 * finest, 4 * finest, ... up to coarsest (world units, 0 < finest <=
  // coarsest); the amplitude of an octave is proportional to wavelength^exponent.
  BandNoise(std::uint64_t seed, double finest_wavelength, double coarsest_wavelength,
            double exponent);

  double operator()(const Eigen::Vector3d& point) const;

 private:
  struct Octave {
    Eigen::Matrix3d lattice_from_world;
    Eigen::Vector3d offset;
    double amplitude;
    std::uint32_t seed;
  };
  std::vector<Octave> octaves_;
};

// Albedo of weathered stone, in grey levels about 30 to 220 (mean 120): grain down to the finest
// wavelength, blotches up to 16 times that, and a contrast that differs between regions by a factor
// of up to 4, so that a scene has well and badly textured parts.
class StoneTexture {
 public:
  StoneTexture(std::uint64_t seed, double finest_wavelength);
  double operator()(const Eigen::Vector3d& point) const;

 private:
  BandNoise grain_;
  BandNoise contrast_;
};

}  // namespace burin
