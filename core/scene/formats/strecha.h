// The cameras of Strecha et al. 2008 (fountain-P11, Herz-Jesu-P8). The file of the photograph NAME is
// NAME.camera or, where the folder has no such file, NAME.P.
//
// NAME.camera has K (3 rows), a row that must be 0 0 0, R (3 rows), the camera's centre C, width and
// height. R maps camera to world: x = K R^T (X - C). NAME.P has the 3x4 matrix P: x = P X. Pixel centres
// are at whole numbers (burin's cx is K's plus 0.5). Photographs have no distortion; there are no points.
// A photograph has the camera's size. If it is smaller or larger by the same factor both ways, the camera
// is scaled with it.
#pragma once

#include <filesystem>

#include "core/scene/formats/posed_images.h"

namespace burin {

bool IsStrecha(const std::filesystem::path& path);

// Photographs are in `images`, beside the cameras, or in images/ beside or above them.
PosedScene ReadStrecha(const std::filesystem::path& path, const std::filesystem::path& images);

}  // namespace burin
