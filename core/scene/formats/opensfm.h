// reconstruction.json of OpenSfM and OpenDroneMap (any NAME.json with "shots", or a folder with reconstruction.json). Of several
// reconstructions in a file the one with most shots is read.
//
// Conventions: X_cam = R X + t with "rotation" an angle times its axis and "translation" t; x right, y down, z forward. Image
// coordinates are shares of the photograph's longer side, from its middle: burin's cx = w/2 + c_x max(w, h), and
// fx = focal_x max(w, h). Cameras may be written for another size than the photograph's, of the same shape: the size is the
// photograph's. Projection types are perspective (focal, k1, k2), simple_radial, radial and brown (focal_x, focal_y, c_x, c_y, k1,
// k2, k3, p1, p2); their lenses are Brown's, in OpenCV's order and sign. Others (fisheye, spherical, dual) are refused where a shot
// uses them.
// Photographs are in images/ beside the file or above it, or beside the file. Which shots see a point, and where, is in
// tracks.csv beside the file; without it points have no views and are dropped.
// Ignored: GPS, biases, rigs (shots have their own poses), reference_lla: the world is the file's, in metres.
#pragma once

#include <filesystem>

#include "core/scene/formats/posed_images.h"

namespace burin {

bool IsOpenSfm(const std::filesystem::path& path);
PosedScene ReadOpenSfm(const std::filesystem::path& path, const std::filesystem::path& images);

}  // namespace burin
