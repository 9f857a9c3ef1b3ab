// cameras.xml that Agisoft Metashape exports ("Export Cameras", Agisoft XML; NAME.xml, or a folder with cameras.xml).
//
// Conventions: a camera's "transform" is chunk_from_camera, row by row, with x right, y down, z forward; its component's (else the
// chunk's) rotation, translation and scale are world_from_chunk, X_world = s R X + t. Where the chunk's reference is a system of the
// Earth that world is geocentric, and meshes are exported in others: the scene stays in the chunk's own frame, with a note.
// Calibrations are in pixels, the first one's centre at (0.5, 0.5), cx and cy from the middle: burin's cx = w/2 + cx, fx = f + b1,
// fy = f. The lens is Brown's with p1 and p2 the other way round than OpenCV's; k4, p3, p4 and b2 (skew) must be 0. The adjusted
// calibration goes before the initial one. Sensors other than frame cameras are refused where a camera uses them.
// Photographs are found by the cameras' labels, with or without an extension, in images/ beside the file or beside it, or in `images`.
// Cameras that are not aligned (no transform) or disabled are left out, with a note. Ignored: markers, references, covariances.
#pragma once

#include <filesystem>

#include "core/scene/formats/posed_images.h"

namespace burin {

bool IsMetashape(const std::filesystem::path& path);
PosedScene ReadMetashape(const std::filesystem::path& path, const std::filesystem::path& images);

}  // namespace burin
