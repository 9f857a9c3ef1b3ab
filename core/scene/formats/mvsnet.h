// The cameras of DTU (pos_NNN.txt), and of MVSNet and its successors (NNNNNNNN_cam.txt).
//
// DTU is a folder with pos_001.txt, ... A file has the 3x4 matrix P of a rectified photograph, x = P X,
// with pixel centres at whole numbers (burin's cx is K's plus 0.5). The photograph of NNN is the file
// whose name has the number NNN between characters that are not digits (rect_001_3_r5000.png,
// clean_001_max.png). Of several such files (lights) burin takes the last by name.
//
// MVSNet is a folder with the files, or whose cams/ has them. A file has "extrinsic", the 4x4 matrix
// [R t; 0 1], "intrinsic", K, and a line with depths, which is ignored; x = K (R X + t). The first
// pixel's centre is at 0.5, as in burin, but for the files of DTU, whose numbers are those of pos_NNN.txt: there
// it is at 0. The photograph of NNNNNNNN is NNNNNNNN.jpg or .png.
//
// Photographs have no distortion. They are in `images`, or beside the files, or in images/ or
// blended_images/ beside or above them. There are no points.
#pragma once

#include <filesystem>

#include "core/scene/formats/posed_images.h"

namespace burin {

bool IsDtu(const std::filesystem::path& path);
PosedScene ReadDtu(const std::filesystem::path& path, const std::filesystem::path& images);

bool IsMvsNet(const std::filesystem::path& path);
PosedScene ReadMvsNet(const std::filesystem::path& path, const std::filesystem::path& images);

}  // namespace burin
