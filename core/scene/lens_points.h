// Puts lens distortion into single image points, and takes it out.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/scene/camera.h"
#include "core/scene/undistort.h"

namespace burin {

// Where the lens photographs what `camera` sees at `undistorted` (pixels both); meaningful up to the radius at which
// the lens folds back only.
Eigen::Vector2d PhotographedAt(const Camera& camera, const Lens& lens,
                               const Eigen::Vector2d& undistorted);

// The other way round.
class PointUndistortion {
 public:
  PointUndistortion(const Camera& camera, const Lens& lens);

  // Where `camera` sees, to 1e-9 of its focal length, what the lens photographed at `photographed` (pixels
  // both). Nothing where that is finite no more, where no point within the radius at which the lens folds back
  // is photographed there, or where that is further out than twice the picture's corner.
  std::optional<Eigen::Vector2d> operator()(const Eigen::Vector2d& photographed) const;

 private:
  Camera camera_;
  Lens lens_;
  double fold_radius_;  // undistorted, normalised
};

}  // namespace burin
