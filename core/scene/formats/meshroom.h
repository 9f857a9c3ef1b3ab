// cameras.sfm of Meshroom and AliceVision, versions 1.0 to 1.2 of the file (NAME.sfm, a NAME.json with "poses", or a folder with
// cameras.sfm).
//
// Conventions: X_cam = R (X - C); "rotation" has R column by column, "center" C; x right, y down, z forward. Numbers are written as
// strings. Pixel centres are at whole numbers. principalPoint is in pixels, from the picture's corner before version 1.2.1 and from its
// middle since. Focal lengths are pixels (pxFocalLength) before 1.2.2, one number before 1.2.0 and two since; then millimetres with
// sensorWidth, and pixelRatio is fx / fy before 1.2.5 and fy / fx since.
// Lenses are Brown's: radial1 (radialk1), radial3 (radialk3) and brown, k1, k2, k3, t1, t2. Other types (fisheye, equidistant, radialk3pt,
// 3DE's), and views of rigs, are refused where a view with a pose has them. Views without a pose are left out, with a note.
// Photographs are where "path" says, else under its last part beside the file or in images/, or in `images`. From the structure the reader
// takes X, the views that observe it and where.
#pragma once

#include <filesystem>

#include "core/scene/formats/posed_images.h"

namespace burin {

bool IsMeshroom(const std::filesystem::path& path);
PosedScene ReadMeshroom(const std::filesystem::path& path, const std::filesystem::path& images);

}  // namespace burin
