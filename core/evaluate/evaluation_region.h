// Where a comparison with the truth means something: the volume that the scanner observed, and the side
// of the table that the object stands on. Each is a plain file that any program can write.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>

namespace burin {

// A grid of cubes, each inside or outside.
struct VoxelMask {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // centre of voxel (0, 0, 0), world units
  double cell_size = 1;                              // edge of a voxel, world units
  Eigen::Vector3i dimensions = Eigen::Vector3i::Zero();
  std::string voxels;  // a byte each, x fastest, then y; 0 = outside

  // The voxel whose centre is nearest, round((point - origin) / cell_size), exists and is not 0.
  bool Contains(const Eigen::Vector3d& point) const;
};

// Reads a mask: a JSON file
//     {"origin": [x, y, z], "cell_size": s, "dimensions": [nx, ny, nz], "voxels": "NAME.raw"}
// with exactly these keys, and beside it (the name is relative to its folder) a file of nx*ny*nz
// bytes, voxel (i, j, k) at i + nx * (j + ny * k). Throws InputError naming file, field and reason.
VoxelMask ReadVoxelMask(const std::filesystem::path& path);

// Reads a plane: a text file of four numbers a b c d, separated by white space, (a, b, c) not zero.
// Points with a x + b y + c z + d > 0 (world units) are above it. Throws InputError.
Eigen::Vector4d ReadPlane(const std::filesystem::path& path);

inline bool IsAbove(const Eigen::Vector4d& plane, const Eigen::Vector3d& point) {
  return plane.head<3>().dot(point) + plane[3] > 0;
}

}  // namespace burin
