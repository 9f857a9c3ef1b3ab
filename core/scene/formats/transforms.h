// transforms.json: cameras as nerfstudio, instant-ngp and the scenes rendered by Blender have them (any NAME.json with
// "frames", or a folder with transforms.json or transforms_train.json).
//
// Conventions: transform_matrix is world_from_camera with OpenGL's axes, x right, y up, z backwards: burin's
// R^T = M diag(1, -1, -1). Pixels are burin's: both programs copy cx and cy from COLMAP, and shoot the ray of the first pixel
// through (0.5, 0.5). The world is the file's own, in which applied_transform and applied_scale have been applied already.
// Intrinsics are of the file or, where a frame has its own, the frame's: fl_x, fl_y, cx, cy, w, h, in pixels; else
// camera_angle_x and camera_angle_y, the angles of view in radians (x_fov and y_fov: in degrees); fl_y is fl_x, cx and cy are the
// middle and w and h the photograph's where they are absent. camera_model is OPENCV, PINHOLE or one of COLMAP's that it
// contains, or absent; the lens is k1, k2, k3, p1, p2 in OpenCV's order and sign. Refused: k4, and lenses that are none of
// Brown's (OPENCV_FISHEYE, EQUIRECTANGULAR, is_fisheye, ftheta, latlong).
// Photographs are named by file_path, beside the file; a name without an extension is that of a PNG or JPEG. Frames
// whose photographs are missing are left out, with a note. mask_path has zero where a pixel is not to be used. Ignored:
// depth maps, ply_file_path, what else trains a radiance field.
#pragma once

#include <filesystem>

#include "core/scene/formats/posed_images.h"

namespace burin {

bool IsTransforms(const std::filesystem::path& path);
PosedScene ReadTransforms(const std::filesystem::path& path, const std::filesystem::path& images);

}  // namespace burin
