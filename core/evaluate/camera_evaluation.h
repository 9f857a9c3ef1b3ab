// Scores the cameras of a scene against true ones, in pixels (core/scene/camera_similarity.h): surveyed cameras
// against those of structure from motion, or refined ones against those that a synthetic scene was made with.
//
// Protocol
//  1. Views are compared with those of the same name. True cameras are taken to the size of the scene's images.
//  2. Surface points are what the views see on a regular grid of pixels, 1500 a view at most
//     (core/visibility/seen_points.h): of the truth in the true cameras where it is a mesh, else of the mesh in the
//     scene's cameras. Call these the first cameras, the others the second.
//  3. The photographs' pixel x at which the first camera and its lens take a point X is where a matcher would find
//     it. It is undistorted by the second camera's lens, and compared with the projection of S X by
//     the second camera. S is the similarity of the world that makes the errors least.
//  4. A view's error is the root of the mean square over its points, |.| in both image coordinates together; that of
//     all is the root of the mean over views of the views' mean squares.
#pragma once

#include <string>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/scene.h"
#include "core/scene/similarity.h"

namespace burin {

struct ViewCameraErrors {
  std::string name;
  int points = 0;
  int behind = 0;  // of these behind the second camera; they count as the image's diagonal
  double px = 0;   // NaN without points
  double center_distance = 0;  // of the centres after the similarity, units of the true world
  double angle_deg = 0;        // between the orientations after it
};

struct CameraEvaluation {
  bool on_truth = false;                // surface points are the truth's
  std::vector<ViewCameraErrors> views;  // in both models, ascending by name
  std::vector<std::string> only_in_scene;
  std::vector<std::string> only_in_truth;
  int views_with_points = 0;
  double rms_px = 0;
  int worst = 0;  // index into `views`
  Similarity truth_from_scene;
};

// `surface` is in the world of `truth` where on_truth, else in that of `scene`. Throws InputError when the
// models have fewer than two views in common, the images of one have another shape, or the views see fewer
// than three points in all.
CameraEvaluation EvaluateCameras(const Scene& scene, const Scene& truth,
                                 const TriangleMesh& surface, bool on_truth);

}  // namespace burin
