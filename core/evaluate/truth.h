// Ground truth: a surface, or points of one.
#pragma once

#include <filesystem>

#include "core/mesh/mesh.h"
#include "core/mesh/point_cloud_io.h"

namespace burin {

// Ground truth: a mesh, or else a point cloud.
struct Truth {
  TriangleMesh mesh;
  PointCloud cloud;
  bool IsMesh() const { return !mesh.faces.empty(); }
  // Whether distances to planes can be measured.
  bool HasNormals() const { return IsMesh() || !cloud.normals.empty(); }
};

// Reads a truth file: a mesh in any format of core/mesh/mesh_io.h, or a PLY without faces as a cloud.
// Throws InputError.
Truth ReadTruth(const std::filesystem::path& path);

// Throws InputError when the truth has no points, or normals that are not one per point.
void CheckTruth(const Truth& truth);

}  // namespace burin
