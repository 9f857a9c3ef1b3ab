// OpenMVS' interchange format (NAME.mvs beginning with "MVSI", versions 0 to 7). It has platforms with
// cameras and poses, images, and points. It is little-endian, field after field; a 64-bit count stands
// before every string and list.
//
// Conventions: K has pixel centres at whole numbers (burin's cx is K's plus 0.5). Where a camera has no
// size, K is divided by the larger side of the image. Poses map world to camera, X_cam = R (X - C). The
// poses of camera and platform are combined: R = R_c R_p, C = C_p + R_p^T C_c. Photographs are
// undistorted.
//
// Read: K (without skew), poses, names of images and masks, points with their views. Ignored: band names,
// depth ranges, view scores, normals, colours, lines, transform, bounding box. Images without a pose are
// left out. OpenMVS' own project files ("MVS") are refused. The mesh is the file NAME_mesh.ply beside, as
// in OpenMVS.
#pragma once

#include <filesystem>

#include "core/scene/formats/posed_images.h"

namespace burin {

bool IsOpenMvs(const std::filesystem::path& path);

// Photographs are where the file says, from its folder on, or in `images` by their file name.
PosedScene ReadOpenMvs(const std::filesystem::path& path, const std::filesystem::path& images);

// Version 6: a camera and a pose per view, names images/NAME and, where there is a mask, masks/NAME.png,
// points in single precision.
void WriteOpenMvs(const Scene& scene, const std::filesystem::path& path);

}  // namespace burin
