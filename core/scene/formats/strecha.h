// The cameras of Strecha et al. 2008 (fountain-P11, Herz-Jesu-P8): for the photograph NAME a file
// NAME.camera or, where no file of the folder is called so, NAME.P.
//
// NAME.camera: K (3 rows), a row that must be 0 0 0, R (3 rows), the camera's centre C, width and
// height. R maps camera to world, x = K R^T (X - C). NAME.P: the 3x4 matrix P, x = P X. Pixel centres
// are at whole numbers (burin's cx is K's plus 0.5). Photographs without distortion, no points. Their
// size is the camera's; where they are smaller or larger by the same factor both ways, the camera is
// scaled with them.
#pragma once

#include <filesystem>

#include "core/scene/formats/posed_images.h"

namespace burin {

bool IsStrecha(const std::filesystem::path& path);

// Photographs are in `images`, beside the cameras, or in images/ beside or above them.
PosedScene ReadStrecha(const std::filesystem::path& path, const std::filesystem::path& images);

}  // namespace burin
