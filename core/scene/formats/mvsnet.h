// The cameras of DTU (pos_NNN.txt) and of MVSNet and what followed it (NNNNNNNN_cam.txt).
//
// DTU: a folder with pos_001.txt, ...: the 3x4 matrix P of the rectified photographs, x = P X, pixel
// centres at whole numbers (burin's cx is K's plus 0.5). The photograph of NNN is the file whose name
// has the number NNN between characters that are no digits (rect_001_3_r5000.png, clean_001_max.png);
// of several (lights) the last by name.
//
// MVSNet: a folder with the files, or with cams/ that has them: "extrinsic", the 4x4 matrix [R t; 0 1],
// x = K (R X + t), "intrinsic", K, and a line with depths, which is ignored. The first pixel's centre is
// at 0.5, as in burin. The photograph of NNNNNNNN is NNNNNNNN.jpg or .png.
//
// Photographs without distortion in `images`, or beside the files, or in images/ or blended_images/
// beside or above them. No points.
#pragma once

#include <filesystem>

#include "core/scene/formats/posed_images.h"

namespace burin {

bool IsDtu(const std::filesystem::path& path);
PosedScene ReadDtu(const std::filesystem::path& path, const std::filesystem::path& images);

bool IsMvsNet(const std::filesystem::path& path);
PosedScene ReadMvsNet(const std::filesystem::path& path, const std::filesystem::path& images);

}  // namespace burin
