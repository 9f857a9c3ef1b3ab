// Middlebury multi-view stereo (temple, dino): NAME_par.txt, or a folder that has one.
//
// The file has the number of photographs, then a line for each: file name, K (9 numbers, row by row),
// R (9), t (3); x = K (R X + t), x right, y down. The data set's README puts the origin "top-left" but
// does not say of what. burin takes pixel centres to be at whole numbers (its cx is K's plus 0.5).
// Photographs have no distortion; they are beside the file or in `images`. There are no points.
#pragma once

#include <filesystem>

#include "core/scene/formats/posed_images.h"

namespace burin {

bool IsMiddlebury(const std::filesystem::path& path);
PosedScene ReadMiddlebury(const std::filesystem::path& path, const std::filesystem::path& images);

}  // namespace burin
