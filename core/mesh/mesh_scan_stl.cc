// STL, binary and text: three corners a facet, each with its position. What OpenMesh gets is the same soup as OFF, in which
// it does not join corners by single precision; core/mesh/weld.h joins them.
#include <cstring>
#include <sstream>

#include "core/mesh/mesh_scan.h"
#include "core/support/error.h"

namespace burin {
namespace {

constexpr std::size_t kHeaderBytes = 84;  // the last four are the count of facets
constexpr std::size_t kFacetBytes = 50;   // normal, three corners, two bytes of attributes

std::uint32_t FacetCount(const std::string& data) {
  std::uint32_t count = 0;
  if (data.size() >= kHeaderBytes) std::memcpy(&count, data.data() + 80, sizeof(count));
  return count;
}

// Text begins with "solid"; so do the headers of some binary files, whose length tells.
bool IsText(const std::string& data) {
  return data.compare(0, 5, "solid") == 0 &&
         data.size() != kHeaderBytes + kFacetBytes * FacetCount(data);
}

void AddCorner(const std::filesystem::path& path, const Eigen::Vector3d& position,
               ScannedMesh* mesh) {
  CheckPosition(path, static_cast<std::int64_t>(mesh->positions.size()), position);
  mesh->positions.push_back(position);
}

void ScanBinary(const std::filesystem::path& path, const std::string& data, ScannedMesh* mesh) {
  const std::uint32_t count = FacetCount(data);
  const std::size_t there =
      data.size() < kHeaderBytes ? 0 : (data.size() - kHeaderBytes) / kFacetBytes;
  if (count > there) {
    throw InputError(path, "header: announces " + std::to_string(count) +
                               " facets, the file is truncated after " + std::to_string(there));
  }
  for (std::uint32_t f = 0; f < count; ++f) {
    float corners[9];
    std::memcpy(corners, data.data() + kHeaderBytes + kFacetBytes * f + 12, sizeof(corners));
    for (int c = 0; c < 3; ++c) {
      AddCorner(path, Eigen::Vector3f(corners + std::ptrdiff_t{3} * c).cast<double>(), mesh);
    }
  }
}

void ScanText(const std::filesystem::path& path, const std::string& data, ScannedMesh* mesh) {
  std::istringstream stream(data);
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    std::istringstream words(line);
    std::string word;
    if (!(words >> word)) continue;
    const bool whole = mesh->positions.size() % 3 == 0;
    if (word == "endfacet" && !whole) {
      throw InputError(path, "line " + std::to_string(number) + ": facet: has not three corners");
    }
    if (word != "vertex") continue;
    Eigen::Vector3d position;
    for (int axis = 0; axis < 3; ++axis) {
      if (!(words >> word) || !ParseNumber(word, &position[axis])) {
        throw InputError(
            path, "line " + std::to_string(number) + ": vertex: '" + word + "' is not a number");
      }
    }
    AddCorner(path, position, mesh);
  }
  if (mesh->positions.size() % 3 != 0) throw InputError(path, "facet: the file is truncated here");
}

}  // namespace

ScannedMesh ScanStl(const std::filesystem::path& path, const std::string& data) {
  ScannedMesh mesh;
  if (IsText(data)) {
    ScanText(path, data, &mesh);
  } else {
    ScanBinary(path, data, &mesh);
  }
  if (mesh.positions.empty()) throw InputError(path, "facets: the mesh has none");
  mesh.face_count = static_cast<std::int64_t>(mesh.positions.size() / 3);
  mesh.text = "OFF\n" + std::to_string(mesh.positions.size()) + " " +
              std::to_string(mesh.face_count) + " 0\n";
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) mesh.text += "0 0 0\n";
  for (std::size_t v = 0; v < mesh.positions.size(); v += 3) {
    mesh.text +=
        "3 " + std::to_string(v) + " " + std::to_string(v + 1) + " " + std::to_string(v + 2) + "\n";
  }
  return mesh;
}

}  // namespace burin
