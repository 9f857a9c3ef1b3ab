// What the layouts of the synthetic scenes share: the scale of a patch 2 units wide, seeds, and the
// cameras.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/scene/camera.h"
#include "core/support/counter_random.h"
#include "core/synthetic/synthetic.h"

namespace burin {

constexpr double kFocalPerWidth = 1.2;

enum class LayoutStream : std::uint64_t { kCamera = 1, kRelief, kBump, kPlace, kSpoil };

// Seed of one random part of a layout.
std::uint64_t LayoutSeed(const SyntheticOptions& options, LayoutStream stream);

// World units per px, and the distance of the cameras, where 2 world units at the scene's centre fill
// 0.92 of the image's width: all scenes but scan and boulder.
double PatchFootprint(const SyntheticOptions& options);
double PatchDistance(const SyntheticOptions& options);
// Of these two: far enough for the unit sphere to fit the narrower field of view.
double OrbitDistance(const SyntheticOptions& options);

// Places cameras on spheres around a target; +z is the direction of azimuth and elevation 0, y is
// up. Every pose gets a small deviation, as a photographer's has. In uneven rigs every third view
// stands 1.7 times as far.
class CameraRig {
 public:
  CameraRig(const SyntheticOptions& options, double distance, const Eigen::Vector3d& target);

  void Add(double azimuth_deg, double elevation_deg);
  // Over azimuths by Spread(), at two elevations in turn. `usual` is the number of views where synth.views
  // leaves it to the scene.
  void AddFan(const SyntheticOptions& options, int usual, double half_range, double even_deg,
              double odd_deg);

  double Footprint() const { return distance_ / intrinsics_.fx; }
  const std::vector<Camera>& cameras() const { return cameras_; }

 private:
  CounterRandom random_;
  bool uneven_;
  double distance_;
  Eigen::Vector3d target_;
  Camera intrinsics_;
  std::vector<Camera> cameras_;
};

// k-th of `count` azimuths over [-half_range, half_range]; uneven ones crowd in the middle.
double Spread(const SyntheticOptions& options, int k, int count, double half_range);

}  // namespace burin
