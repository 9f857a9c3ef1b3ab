// Middlebury multi-view stereo (temple, dino): NAME_par.txt, or a folder that has one.
//
// The number of photographs, then a line for each: file name, K (9 numbers, row by row), R (9), t (3);
// x = K (R X + t), x right, y down. The README has the origin "top-left" without saying of what; pixel
// centres are taken to be at whole numbers (burin's cx is K's plus 0.5). Photographs without
// distortion, beside the file or in `images`; no points.
#pragma once

#include <filesystem>

#include "core/scene/formats/posed_images.h"

namespace burin {

bool IsMiddlebury(const std::filesystem::path& path);
PosedScene ReadMiddlebury(const std::filesystem::path& path, const std::filesystem::path& images);

}  // namespace burin
