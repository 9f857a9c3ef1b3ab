// How large a face is in a photograph: what decides whether the photograph can refine it further.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/camera.h"

namespace burin {

// Area in px^2 of the part of triangle abc that lies inside the image, in front of the camera.
// Exact: the triangle is clipped by the four side planes of the viewing pyramid, so a face that
// reaches behind the camera or far beyond the image counts with what is seen of it. Orientation and
// occlusion are not looked at. A part of a triangle never has a larger area than the whole.
// What is nearer than `near_depth` does not count. `projection` is the camera's ProjectionMatrix().
double ProjectedArea(const Eigen::Matrix<double, 3, 4>& projection, int width, int height,
                     double near_depth, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                     const Eigen::Vector3d& c);
double ProjectedArea(const Camera& camera, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                     const Eigen::Vector3d& c);

// The camera is on the side of the face that its normal points to.
bool FacesCamera(const TriangleMesh& mesh, int face, const Camera& camera);

// The largest ProjectedArea of a face over the cameras it faces, px^2: its size in its sharpest
// view. 0 when no camera sees it.
double SharpestArea(const TriangleMesh& mesh, int face, const std::vector<Camera>& cameras);

}  // namespace burin
