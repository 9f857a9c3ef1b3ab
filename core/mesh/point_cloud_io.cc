#include "core/mesh/point_cloud_io.h"

#include <glog/logging.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>

#include "core/mesh/mesh_scan.h"
#include "core/mesh/ply_header.h"
#include "core/support/atomic_file.h"
#include "core/support/error.h"

namespace burin {
namespace {

// A header line is short: a limit keeps a binary file without line ends out of memory.
std::string ReadHeaderLine(std::istream* file, const std::filesystem::path& path) {
  constexpr size_t kLongest = 4096;
  std::string line;
  for (int c = file->get(); c != '\n'; c = file->get()) {
    if (c == EOF) throw InputError(path, "header: ends before end_header");
    if (line.size() >= kLongest) {
      throw InputError(path, "header: line longer than " + std::to_string(kLongest) + " bytes");
    }
    line.push_back(static_cast<char>(c));
  }
  return line;
}

// False at the end of the file or where an ascii word is not a number.
bool ReadNumber(std::istream* file, const PlyHeader& header, const PlyType& type, double* value) {
  if (header.ascii) {
    std::string word;
    return *file >> word && ParseNumber(word, value);
  }
  std::array<char, 8> bytes;
  if (!file->read(bytes.data(), type.size)) return false;
  *value = DecodePlyNumber(bytes.data(), type, header.big_endian);
  return true;
}

}  // namespace

PointCloud ReadPointCloud(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw InputError(path, "no such file");
  const std::uint64_t file_bytes = std::filesystem::file_size(path, error);
  std::ifstream file(path, std::ios::binary);
  if (error || !file) throw InputError(path, "cannot be read");
  const PlyHeader header = ReadPlyHeader(path, [&] { return ReadHeaderLine(&file, path); });
  const std::uint64_t body_bytes = file_bytes - static_cast<std::uint64_t>(file.tellg());

  for (const PlyElement& element : header.elements) {
    const std::uint64_t row_bytes = LeastEntryBytes(element, header);
    // Rows without properties take no bytes and give nothing to read.
    if (row_bytes > 0 && element.count > (body_bytes + 1) / row_bytes) {
      throw InputError(path, "element " + element.name + ": count " +
                                 std::to_string(element.count) + " needs more than the " +
                                 std::to_string(body_bytes) + " bytes after the header");
    }
    const bool is_vertex = element.name == "vertex";
    static const std::array<std::string, 6> kNames = {"x", "y", "z", "nx", "ny", "nz"};
    std::vector<int> slot(element.properties.size(), -1);  // into `row` below, -1 = skipped
    std::array<bool, 6> has{};
    for (size_t p = 0; is_vertex && p < element.properties.size(); ++p) {
      const auto name = std::find(kNames.begin(), kNames.end(), element.properties[p].name);
      if (name == kNames.end() || element.properties[p].count_type != nullptr) continue;
      slot[p] = static_cast<int>(name - kNames.begin());
      has[slot[p]] = true;
    }
    for (int axis = 0; is_vertex && axis < 3; ++axis) {
      if (!has[axis])
        throw InputError(path, "element vertex: property " + kNames[axis] + " missing");
    }
    const bool has_normals = has[3] && has[4] && has[5];

    PointCloud cloud;
    if (is_vertex) {
      cloud.points.reserve(element.count);
      if (has_normals) cloud.normals.reserve(element.count);
    }
    for (std::uint64_t index = 0; row_bytes > 0 && index < element.count; ++index) {
      std::array<double, 6> row{};
      bool complete = true;
      bool finite = true;
      for (size_t p = 0; complete && p < element.properties.size(); ++p) {
        const PlyProperty& property = element.properties[p];
        double value = 0;
        if (property.count_type != nullptr) {
          double count = 0;
          complete = ReadNumber(&file, header, *property.count_type, &count) && count >= 0;
          for (double k = 0; complete && k < count; ++k) {
            complete = ReadNumber(&file, header, *property.type, &value);
          }
          continue;
        }
        complete = ReadNumber(&file, header, *property.type, &value);
        if (slot[p] < 0 || (slot[p] >= 3 && !has_normals)) continue;
        row[slot[p]] = value;
        finite = finite && std::isfinite(value);
      }
      const auto fail = [&](const std::string& reason) {
        throw InputError(path, element.name + " " + std::to_string(index) + ": " + reason);
      };
      if (!complete) fail("cut off or not a number");
      if (!is_vertex) continue;
      if (!finite) fail("not finite");
      cloud.points.emplace_back(row[0], row[1], row[2]);
      if (has_normals) cloud.normals.emplace_back(row[3], row[4], row[5]);
    }
    if (is_vertex) return cloud;
  }
  throw InputError(path, "element vertex: missing in the header");
}

void WritePointCloud(const std::filesystem::path& path, const PointCloud& cloud) {
  const bool has_normals = !cloud.normals.empty();
  CHECK(!has_normals || cloud.normals.size() == cloud.points.size());
  WriteAtomically(path, [&](const std::filesystem::path& temporary) {
    std::ofstream file(temporary, std::ios::binary);
    file << "ply\nformat binary_little_endian 1.0\nelement vertex " << cloud.points.size()
         << "\nproperty float x\nproperty float y\nproperty float z\n";
    if (has_normals) file << "property float nx\nproperty float ny\nproperty float nz\n";
    file << "end_header\n";
    const auto put = [&](const Eigen::Vector3d& vector) {
      for (int axis = 0; axis < 3; ++axis) {
        const auto value = static_cast<float>(vector[axis]);
        std::uint32_t bits;
        std::memcpy(&bits, &value, sizeof(bits));
        for (int shift = 0; shift < 32; shift += 8) {
          file.put(static_cast<char>((bits >> shift) & 0xFF));
        }
      }
    };
    for (size_t p = 0; p < cloud.points.size(); ++p) {
      put(cloud.points[p]);
      if (has_normals) put(cloud.normals[p]);
    }
    file.close();
    if (!file) throw InputError(path, "cannot be written");
  });
}

}  // namespace burin
