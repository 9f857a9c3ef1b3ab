// Bundler's output: NAME.out, or a folder with bundle.out or bundle/bundle.out. NAME.out.list.txt or, for
// X.bundle.out, X.list.txt beside it (COLMAP writes these), or list.txt, beside it or above, names one
// photograph per line.
//
// The file has "# Bundle file v0.3", the numbers of cameras and points, the cameras and the points. A
// camera is f k1 k2, R (3 rows), t. A point is its position, its colour, and the cameras that see it.
//
// Bundler looks along -z with y up, and has the origin of the image in its middle: with P = R X + t and
// p = -(P_x, P_y) / P_z a point is at f (1 + k1 |p|^2 + k2 |p|^4) p, y up. So burin's R and t are
// diag(1, -1, -1) times Bundler's, cx and cy are the middle of the image, and the lens is Brown's with
// the same k1 and k2. Bundler did not place cameras with f = 0; they are left out. Ignored: colours,
// keys, image positions of points.
#pragma once

#include <filesystem>

#include "core/scene/formats/posed_images.h"

namespace burin {

bool IsBundler(const std::filesystem::path& path);
PosedScene ReadBundler(const std::filesystem::path& path, const std::filesystem::path& images);

}  // namespace burin
