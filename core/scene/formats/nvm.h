// VisualSFM's NAME.nvm (NVM_V3), the first model in it.
//
// "NVM_V3" with, for a shared calibration, "FixedK fx cx fy cy r"; the number of cameras; a line for each:
// photograph (blanks written as "), focal length, quaternion w x y z and centre C of X_cam = R (X - C),
// radial distortion r, 0. Then the number of points; a line for each: position, colour, and the views
// as (camera, feature, x, y). The principal point is the middle of the image, or FixedK's, whose first
// pixel is taken to have its centre at a whole number. The lens is VisualSFM's: undistorted = measured
// (1 + r |measured|^2) in normalised coordinates. Ignored: colours, image positions, further models.
#pragma once

#include <filesystem>

#include "core/scene/formats/posed_images.h"

namespace burin {

bool IsNvm(const std::filesystem::path& path);

// Photographs are where the file says, from its folder on, or in `images`.
PosedScene ReadNvm(const std::filesystem::path& path, const std::filesystem::path& images);

}  // namespace burin
