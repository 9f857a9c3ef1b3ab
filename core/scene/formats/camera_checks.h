// Checks that the cameras of a scene must pass, whatever format they came from.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "core/scene/scene.h"

namespace burin {

// Throws InputError, naming `file` and the camera, unless every camera has a positive image size,
// focal lengths of .1 to 50 times the longer side and a principal point within 1e9 pixels, and a pose whose rotation is one
// (orthonormal to 1e-6, determinant +1) and whose translation is within 1e17 world units.
void CheckCameras(const std::vector<View>& views, const std::filesystem::path& file);

// Throws InputError unless at least two of the cameras have different centres: nothing can be seen
// from two sides otherwise. Views that share a centre beside others are no error; they make no pair.
void CheckCentresDiffer(const std::vector<View>& views, const std::filesystem::path& file);

// The same camera to 12 digits, with the bits beyond rounded off: formats write one camera as different
// numbers (a quaternion or a matrix, t or the centre), and a refinement turns a difference in the last
// bit into another mesh, as good but not the same.
Camera Rounded(const Camera& camera);

// The rotation nearest to `matrix` (Frobenius norm). Formats write rotations with few digits; what is
// further than 1e-3 (any entry of M M^T - I) from one, or mirrors, is an InputError about `element` of
// `file`.
Eigen::Matrix3d NearestRotation(const Eigen::Matrix3d& matrix, const std::filesystem::path& file,
                                const std::string& element);

}  // namespace burin
