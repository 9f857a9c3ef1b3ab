// openMVG's sfm_data as JSON (any NAME.json with "sfm_data_version").
//
// Conventions: X_cam = R (X - C) with "rotation" and "center" of the extrinsics; pixel centres are at
// whole numbers (burin's cx is principal_point's plus 0.5). Intrinsics are pinhole, pinhole_radial_k1,
// pinhole_radial_k3 and pinhole_brown_t2; their lenses are Brown's. Others (fisheye, spherical) are
// refused where a view with a pose uses them. Views without a pose or intrinsics are left out.
// Photographs are in root_path, or in `images`. From the structure the reader takes X and the views that
// observe it. Ignored: image positions, priors, control points.
#pragma once

#include <filesystem>

#include "core/scene/formats/posed_images.h"

namespace burin {

bool IsOpenMvg(const std::filesystem::path& path);
PosedScene ReadOpenMvg(const std::filesystem::path& path, const std::filesystem::path& images);

}  // namespace burin
