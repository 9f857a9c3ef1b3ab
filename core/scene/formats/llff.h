// poses_bounds.npy: cameras as LLFF and NeRF's forward-facing scenes have them (Mildenhall et al. 2019): an array of N x 17.
//
// Conventions: a row is a matrix of 3 x 5, row by row, then the nearest and the farthest depth. The matrix's columns are the
// camera's axes in the world, down, right and backwards, its centre, and (height, width, focal length) in pixels: burin's
// R^T = (right, down, -backwards). Pixels are square, the principal point is the middle, lenses have no distortion.
// Row i is of the i-th photograph by name in images/ beside the file, or in `images`; there must be N. Photographs that were made
// smaller (images_4/) are taken with --images, and the cameras are scaled like them. Ignored: depths.
#pragma once

#include <filesystem>

#include "core/scene/formats/posed_images.h"

namespace burin {

bool IsLlff(const std::filesystem::path& path);
PosedScene ReadLlff(const std::filesystem::path& path, const std::filesystem::path& images);

}  // namespace burin
