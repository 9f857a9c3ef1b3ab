// VisualSFM's NAME.nvm (NVM_V3), the first model in it.
//
// The file begins with "NVM_V3"; a shared calibration follows as "FixedK fx cx fy cy r". Then come
//  - the number of cameras and a line for each: photograph (blanks written as "), focal length,
//    quaternion w x y z and centre C of X_cam = R (X - C), radial distortion r, 0;
//  - the number of points and a line for each: position, colour, and the views as (camera, feature, x, y).
//
// The principal point is the middle of the image, or FixedK's. With FixedK, burin takes pixel centres to
// be at whole numbers. The lens is VisualSFM's: undistorted = measured (1 + r |measured|^2) in normalised
// coordinates. Ignored: colours, image positions, further models.
#pragma once

#include <filesystem>

#include "core/scene/formats/posed_images.h"

namespace burin {

bool IsNvm(const std::filesystem::path& path);

// Photographs are where the file says, from its folder on, or in `images`.
PosedScene ReadNvm(const std::filesystem::path& path, const std::filesystem::path& images);

}  // namespace burin
