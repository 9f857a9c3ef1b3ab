// The scene's own sparse tracks, those that structure from motion measured, beside the windows that match through the mesh
// (core/cameras/mesh_tracks.h). They link views that see the surface from too far apart for windows to match, and do not know
// the mesh: where it is rough, or the cameras are pixels off, they bound what windows leave weak.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/scene/scene.h"
#include "core/scene/tracks.h"

namespace burin {

// Appends the points with at least two measurements that give each view kSparseTracks of them, if it has as many: longer
// tracks first, of equal ones the scene's order. The first measurement of each view counts.
constexpr int kSparseTracks = 200;
void AppendSparseTracks(const Scene& scene, std::vector<Eigen::Vector3d>* points, Tracks* tracks);

}  // namespace burin
