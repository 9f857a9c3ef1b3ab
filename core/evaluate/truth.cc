#include "core/evaluate/truth.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <sstream>
#include <string>

#include "core/mesh/mesh_io.h"
#include "core/support/error.h"

namespace burin {
namespace {

// A PLY header declares faces.
bool PlyHasFaces(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string line;
  // Headers are short; a file without one must not be read to its end.
  for (int k = 0; k < 1000 && std::getline(file, line); ++k) {
    std::istringstream words(line);
    std::string keyword, element;
    long long count = 0;
    words >> keyword;
    if (keyword == "end_header") break;
    if (keyword == "element" && words >> element >> count && element == "face") return count > 0;
  }
  return false;
}

}  // namespace

Truth ReadTruth(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char letter) { return std::tolower(letter); });
  Truth truth;
  if (extension == ".ply" && !PlyHasFaces(path)) {
    truth.cloud = ReadPointCloud(path);
  } else {
    truth.mesh = ReadMesh(path);
  }
  return truth;
}

void CheckTruth(const Truth& truth) {
  if (truth.IsMesh()) return;
  if (truth.cloud.points.empty()) throw InputError("evaluation: the truth has no points");
  if (!truth.cloud.normals.empty() && truth.cloud.normals.size() != truth.cloud.points.size()) {
    throw InputError("evaluation: the truth has " + std::to_string(truth.cloud.points.size()) +
                     " points and " + std::to_string(truth.cloud.normals.size()) + " normals");
  }
}

}  // namespace burin
