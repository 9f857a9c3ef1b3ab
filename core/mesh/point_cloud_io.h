// Point clouds with or without normals, as PLY: what ground truth comes as (laser scans, sampled
// synthetic surfaces) and what evaluation measures against.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

namespace burin {

struct PointCloud {
  std::vector<Eigen::Vector3d> points;   // world units
  std::vector<Eigen::Vector3d> normals;  // outward, as stored in the file; empty = none
};

// Reads the element "vertex" of a PLY file: ascii, binary_little_endian or binary_big_endian, the
// properties x y z (and nx ny nz when all three exist) of any number type and in any order; other
// properties and elements are skipped, so a mesh file is read as its vertices. The counts of the
// header are checked against the length of the file before memory is taken.
// Throws InputError naming the file and the header field, or the first vertex that is cut off or
// not finite.
PointCloud ReadPointCloud(const std::filesystem::path& path);

// Writes binary little-endian PLY with float properties x y z, and nx ny nz when there are normals,
// which then must be as many as points. Throws InputError when the file cannot be written.
void WritePointCloud(const std::filesystem::path& path, const PointCloud& cloud);

}  // namespace burin
