// Does to synthetic photographs what goes wrong with real ones: `synth.stress`.
//
//   none
//   exposure      the views' gains step from 0.6 to 1.5, offsets from -20 to 20 grey levels
//   saturated     a third of every third view is overexposed six times
//   mover         a textured disc, a quarter of the image high, is in front of everything in two views,
//                 in different places
//   textureless   patches of about 80 px without any texture, half of the surface
//   repeated      the texture of a cube of 20 px, again and again
//   pose          the calibration of one view is rotated so that its image is off by 3 px
#pragma once

#include <Eigen/Core>
#include <functional>
#include <opencv2/core.hpp>

#include "core/scene/camera.h"
#include "core/support/choices.h"
#include "core/support/counter_random.h"

namespace burin {

enum class StressKind { kNone, kExposure, kSaturated, kMover, kTextureless, kRepeated, kPose };
inline Choices<StressKind> ChoicesOf(StressKind) {
  return {{StressKind::kNone, "none"},
          {StressKind::kExposure, "exposure"},
          {StressKind::kSaturated, "saturated"},
          {StressKind::kMover, "mover"},
          {StressKind::kTextureless, "textureless"},
          {StressKind::kRepeated, "repeated"},
          {StressKind::kPose, "pose"}};
}

struct Exposure {
  double gain = 1;
  double offset = 0;  // grey levels
};

// `truth` with an error in its pose, as structure from motion leaves one. In standard deviations of
// independent normal numbers: rotation about the camera's x and y axes px / f each, about its optical
// axis 2 px / f; centre, for each coordinate, 0.5 px / f times its distance from the world's origin.
// `random` numbers `6 view` to `6 view + 5` are used.
Camera WithPoseNoise(const Camera& truth, double px, const CounterRandom& random, int view);

// `truth` with an error in what calibration gives: both focal lengths times exp(focal n), the principal point
// moved by px n along each coordinate, n independent normal numbers. `random` numbers `3 camera` to `3 camera +
// 2` are used: views of one camera have one error.
Camera WithIntrinsicsNoise(const Camera& truth, double focal, double px,
                           const CounterRandom& random, int camera);

class Stress {
 public:
  // `footprint` in world units per px.
  Stress(StressKind kind, double footprint) : kind_(kind), footprint_(footprint) {}

  // Albedo at a point, from the texture without stress.
  double Albedo(const std::function<double(const Eigen::Vector3d&)>& texture,
                const Eigen::Vector3d& point) const;
  // `usual` is that without stress.
  Exposure ExposureOf(int view, const Exposure& usual) const;
  // Of `count` views: what comes between the surface and the sensor. `texture` is that of the scene.
  void ChangeRadiance(int view, int count,
                      const std::function<double(const Eigen::Vector3d&)>& texture,
                      cv::Mat1f* radiance) const;
  // The calibration that the scene gives for a camera.
  Camera Calibration(int view, int count, const Camera& truth) const;

 private:
  StressKind kind_;
  double footprint_;
};

}  // namespace burin
