// How far two sets of cameras of the same photographs are apart, in pixels. Photographs do not say where
// the world's origin is, how it is turned and how large it is: cameras that differ by a similarity only
// are the same. So the similarity is fitted first, where it matters: on the surface that the views see.
//
// With X a surface point in the world of the first set, seen in view v at x by the first camera, and pi'_v the
// projection of v by the second camera,
//     E(S) = sum over views of  mean over their points of |pi'_v(S X) - x|^2.
// A similarity of camera centres would let rotation and translation trade: a picture hardly changes when a
// camera moves sideways and turns back.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/scene/camera.h"
#include "core/scene/similarity.h"

namespace burin {

// A surface point and where a camera sees it, pixels.
struct Sighting {
  Eigen::Vector3d point;
  Eigen::Vector2d pixel;
};

// By view: where its camera sees its points. CHECKs that both lists have an item a view.
std::vector<std::vector<Sighting>> SightingsOf(
    const std::vector<Camera>& cameras, const std::vector<std::vector<Eigen::Vector3d>>& points);

struct CameraErrors {
  // By view: root of the mean over its points of |pi'_v(S X) - x|^2. A point behind the camera counts as the
  // diagonal of the image. NaN for a view without points.
  std::vector<double> view_px;
  std::vector<int> behind;  // by view: points behind the camera
  int views = 0;            // with points
  double rms_px = 0;        // root of the mean of view_px^2 over these; 0 without one
};

// For a given S = `motion`. CHECKs that both lists have an item a view.
CameraErrors MeasureCameraErrors(const std::vector<Camera>& second,
                                 const std::vector<std::vector<Sighting>>& sightings,
                                 const Similarity& motion);

struct CameraSimilarity {
  Similarity second_from_first;  // S: Moved(first[v], S) is to be compared with second[v]
  CameraErrors errors;           // under S
  int iterations = 0;
};

// The S that minimises E, by Gauss-Newton in seven parameters about the points' centroid, steps halved until E
// falls. Starts at the identity, or at the similarity of mean orientation and of the centres' mean and spread
// where E is smaller there. No view weighs more or less than another, and none is left out for being far off.
// Directions that nothing holds (the size, with one view) stay as they are at the start. The sums are made in
// order: the same bytes on any number of threads.
//
// False with *error for fewer than three points in all. CHECKs that all lists have an item a view.
bool FitCameraSimilarity(const std::vector<Camera>& first, const std::vector<Camera>& second,
                         const std::vector<std::vector<Sighting>>& sightings, CameraSimilarity* fit,
                         std::string* error);

// The same where the first cameras see `points`.
bool FitCameraSimilarity(const std::vector<Camera>& first, const std::vector<Camera>& second,
                         const std::vector<std::vector<Eigen::Vector3d>>& points,
                         CameraSimilarity* fit, std::string* error);

}  // namespace burin
