// cameras_sphere.npz: cameras as IDR, VolSDF and NeuS have them, the form in which DTU's scans are passed around (a folder with
// cameras_sphere.npz or cameras.npz, or a NAME.npz with world_mat_0).
//
// Conventions: world_mat_i, 4 x 4 or 3 x 4, is a projection matrix P = K [R | t] up to scale; pixel centres are at whole numbers
// (the matrices are DTU's, and rays are shot through whole pixels). scale_mat_i, which takes the unit sphere of the training to the
// world, is ignored: the scene's world is that of world_mat.
// i is of the i-th photograph by name in image/ beside the file, in images/ or rgb/ where that is missing, or in `images`. Masks in
// mask/ or masks/ beside, as many as photographs, go with them in the same order: zero is a pixel not to be used.
#pragma once

#include <filesystem>

#include "core/scene/formats/posed_images.h"

namespace burin {

bool IsNeus(const std::filesystem::path& path);
PosedScene ReadNeus(const std::filesystem::path& path, const std::filesystem::path& images);

}  // namespace burin
