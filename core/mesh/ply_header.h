// What the two readers of PLY files share: a mesh (core/mesh/mesh_scan.h) is in memory, a point cloud
// (core/mesh/point_cloud_io.h) streams, since laser scans are large.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace burin {

struct PlyType {
  const char* name;  // one of two that the format has: char or int8
  int size;          // bytes in a binary file
  char kind;         // i: signed, u: unsigned, f: floating point
};

struct PlyProperty {
  std::string name;
  const PlyType* type = nullptr;
  const PlyType* count_type = nullptr;  // of a list, never floating point; null otherwise
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;  // what the header says: compare it with the file before memory is taken
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  std::string format;  // ascii, binary_little_endian or binary_big_endian
  bool ascii = false;
  bool big_endian = false;
  std::vector<PlyElement> elements;  // of different names
};

// next_line gives the lines of the file in turn, without '\n', and throws where there are no more.
// Throws InputError naming the field.
PlyHeader ReadPlyHeader(const std::filesystem::path& path,
                        const std::function<std::string()>& next_line);

// Bytes that an entry of the element takes at least: in text a digit and a separator a number (the
// last one of the file needs no separator), in binary files that of empty lists.
std::uint64_t LeastEntryBytes(const PlyElement& element, const PlyHeader& header);

// A number of a binary file, from type.size bytes.
double DecodePlyNumber(const char* bytes, const PlyType& type, bool big_endian);

}  // namespace burin
