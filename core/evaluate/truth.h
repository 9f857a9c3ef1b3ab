// Ground truth: a surface, or points of one.
#pragma once

#include <algorithm>
#include <filesystem>

#include "core/mesh/mesh.h"
#include "core/mesh/point_cloud_io.h"

namespace burin {

// Ground truth: a mesh, or else a point cloud.
struct Truth {
  TriangleMesh mesh;
  PointCloud cloud;
  bool IsMesh() const { return !mesh.faces.empty(); }
  // Whether distances to planes can be measured. Converters of clouds without normals write zeros.
  bool HasNormals() const {
    return IsMesh() || std::any_of(cloud.normals.begin(), cloud.normals.end(),
                                   [](const Eigen::Vector3d& normal) { return !normal.isZero(0); });
  }
};

// Reads a truth file: a mesh in any format of core/mesh/mesh_io.h, or a PLY without faces as a cloud.
// Throws InputError.
Truth ReadTruth(const std::filesystem::path& path);

// How large the truth is, world units: the diameter of the ball about the truth's centre that holds 98 %
// of its points (those of a mesh: spread evenly over its area). The centre is the mean of the 98 % that
// are nearest to the mean of all. It follows the truth through any rigid motion and scale, and a few
// points far off hardly change it. 0 for a single point or a mesh without area.
double DiameterOf(const Truth& truth);

// Throws InputError when the truth has no points, or normals that are not one per point.
void CheckTruth(const Truth& truth);

}  // namespace burin
