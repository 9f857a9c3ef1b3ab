// How well tracks determine the poses of a scene's views: standard deviations in pixels of the surface they see.
//
// With J_c, J_p the derivatives of the measurements by rotation and centre of the views and by the tracks' points, each row in
// units of its standard deviation and weighted by the loss, and W the prior of core/cameras/bundle.h, the points are eliminated:
//
//   S = J_c^T J_c + W^T W - J_c^T J_p (J_p^T J_p)^-1 J_p^T J_c.
//
// S hardly knows the seven freedoms of each group's world. With Z their effect on the poses and M the mean over a view's surface points of
// D^T D, D the derivative of their image points by the pose, those are held where the surface's
// image moves least (Z^T M delta = 0). A view's standard deviation is then sqrt(trace(M_v C_v)), C_v its 6x6 block of the
// covariance.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/cameras/mesh_tracks.h"
#include "core/scene/camera.h"

namespace burin {

// More views than these would need a matrix too large to invert.
constexpr int kMostViewsWithDeviations = 400;

// Of every view, pixels of its photograph; NaN for one in no group, and for all in scenes of too many views.
// `sigma` and `loss_px` in pixels of the images searched; `surface`: points that the view sees.
std::vector<double> PoseDeviations(const std::vector<Camera>& cameras, const MeshTracks& tracks,
                                   double sigma, double loss_px,
                                   const std::vector<std::vector<Eigen::Vector3d>>& surface);

}  // namespace burin
