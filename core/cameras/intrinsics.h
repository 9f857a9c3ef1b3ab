// Intrinsics as unknowns of the bundle adjustment (core/cameras/bundle.h): focal length, principal point and the
// coefficients of the lens, one set of them for all photographs that share a camera.
//
// A camera has ten numbers, q = 0 at the start, each in pixels of the photograph:
//
//   0      both focal lengths, times 1 + q / (half the longer side): pixels at the picture's edge
//   1      fy alone, times 1 + q / (half the height)
//   2, 3   principal point
//   4..9   k1, k2, p1, p2, k3, and the lens as VisualSFM measures it (core/scene/undistort.h): by how much they move the picture's corner
//
// So one prior serves all. Pixels that are square as read (fx = fy) stay so. Coefficients are refined that the camera model has, as it was read, and that a
// model can be written with: k3 and VisualSFM's, which are in no model of COLMAP's, where they are not 0.
#pragma once

#include <array>
#include <vector>

#include "core/scene/camera.h"
#include "core/scene/cameras_options.h"
#include "core/scene/scene.h"
#include "core/scene/undistort.h"

namespace burin {

constexpr int kIntrinsics = 10;
constexpr int kFocal = 0;
constexpr int kRatio = 1;
constexpr int kCenter = 2;
constexpr int kBrown = 4;
constexpr int kMeasured = 9;
using IntrinsicNumbers = std::array<double, kIntrinsics>;

// Measurements, of all photographs of a camera: with fewer it keeps its intrinsics.
constexpr int kFewestForIntrinsics = 60;

enum class IntrinsicUnknowns { kNone, kFocal, kLens };

inline IntrinsicUnknowns IntrinsicsOf(CameraUnknowns refine) {
  return refine == CameraUnknowns::kPosesFocal        ? IntrinsicUnknowns::kFocal
         : refine == CameraUnknowns::kPosesIntrinsics ? IntrinsicUnknowns::kLens
                                                      : IntrinsicUnknowns::kNone;
}

// Photographs of one camera.
struct SharedIntrinsics {
  std::vector<int> views;
  Camera camera;  // at the start; its pose means nothing
  Lens lens;
  IntrinsicNumbers unit = {};  // what a pixel is of each number
  std::array<bool, kIntrinsics> free = {};
  int measurements = 0;
  // Standard deviations of q, at most the prior's; 0 of what is not free, NaN where not known.
  IntrinsicNumbers deviation_px = {};

  bool AnyFree() const;
  Camera CameraAt(const IntrinsicNumbers& q) const;
  Lens LensAt(const IntrinsicNumbers& q) const;
};

// In the order of their first views. Photographs share a camera that have the same number of it, or no number, and the same size, model
// and intrinsics: without numbers those are most likely of one calibration. None for kNone. Those whose
// photograph has a lens, but no file to be undistorted from again, are not free.
std::vector<SharedIntrinsics> CamerasSharedIn(const Scene& scene, IntrinsicUnknowns unknowns);

// Whether a lens folds back nearer to the middle of its picture than the scene's does.
bool FoldsEarlier(const Scene& scene, const std::vector<Camera>& cameras,
                  const std::vector<Lens>& lenses);

}  // namespace burin
