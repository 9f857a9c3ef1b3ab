// First of the two passes over a mesh file; core/mesh/mesh_io.cc gives what it returns to OpenMesh.
//
// OpenMesh 9 parses PLY, OBJ and OFF but trusts them: it keeps coordinates as float only, allocates
// and loops by the counts a header claims, leaves out OBJ lines it cannot parse (which shifts every
// later index), reads past list properties it does not know at the wrong offset, and takes a
// truncated file for a shorter one. So the file is walked here first: every count is checked
// against the bytes that are there, every coordinate is read as double, and what OpenMesh would
// trip over (colours, textures, materials, other elements) is left out of the text it gets.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace burin {

struct ScannedMesh {
  std::vector<Eigen::Vector3d> positions;  // finite
  std::int64_t face_count = 0;             // faces of three or more different vertices in `text`
  std::int64_t skipped_face_count = 0;     // OBJ faces with fewer, which OpenMesh leaves out
  std::string text;                        // the file, reduced to positions and index lists
};

// `data` is the whole file; `path` is for messages. All throw InputError naming the field, line or
// element that is wrong, without allocating more than a small multiple of data.size().
ScannedMesh ScanPly(const std::filesystem::path& path, const std::string& data);
ScannedMesh ScanObj(const std::filesystem::path& path, const std::string& data);
ScannedMesh ScanOff(const std::filesystem::path& path, const std::string& data);
ScannedMesh ScanStl(const std::filesystem::path& path, const std::string& data);

// The whole token is a number: decimal, with exponent, nan or inf (numbers too large to hold are
// inf). Independent of the locale.
bool ParseNumber(std::string_view token, double* value);
bool ParseInteger(std::string_view token, std::int64_t* value);

// Throws InputError "vertex 12: x is nan, ..." unless all coordinates are finite and below 1e30,
// where squared lengths still fit and OpenMesh's float does not overflow.
void CheckPosition(const std::filesystem::path& path, std::int64_t vertex,
                   const Eigen::Vector3d& position);

}  // namespace burin
