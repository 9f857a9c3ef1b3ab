#include "core/evaluate/evaluation_region.h"

#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/support/error.h"
#include "core/support/file_bytes.h"
#include "core/support/json_file.h"

namespace burin {
namespace {

constexpr std::uint64_t kMaxDimension = 1000000;  // so that the product of three fits 64 bits

bool IsTriple(const nlohmann::json& value) { return value.is_array() && value.size() == 3; }

std::string Product(const Eigen::Vector3i& dimensions) {
  return std::to_string(dimensions[0]) + " x " + std::to_string(dimensions[1]) + " x " +
         std::to_string(dimensions[2]);
}

}  // namespace

bool VoxelMask::Contains(const Eigen::Vector3d& point) const {
  const Eigen::Array3d index = ((point - origin) / cell_size).array().round();
  // Compared as doubles: a point far away has no index.
  if (!(index >= 0).all() || !(index < dimensions.cast<double>().array()).all()) return false;
  const Eigen::Array<std::int64_t, 3, 1> at = index.cast<std::int64_t>();
  return voxels[at[0] + dimensions[0] * (at[1] + dimensions[1] * at[2])] != 0;
}

VoxelMask ReadVoxelMask(const std::filesystem::path& path) {
  nlohmann::json json = ReadJsonFile(path);
  if (!json.is_object()) {
    throw InputError(path, "must be {\"origin\", \"cell_size\", \"dimensions\", \"voxels\"}");
  }
  for (const auto& [key, value] : json.items()) {
    if (key != "origin" && key != "cell_size" && key != "dimensions" && key != "voxels") {
      throw InputError(path, key + ": unknown; origin, cell_size, dimensions, voxels are known");
    }
  }
  VoxelMask mask;
  const nlohmann::json& origin = json["origin"];  // null when it is missing, as below
  if (!IsTriple(origin)) throw InputError(path, "origin: must be three numbers");
  const nlohmann::json& dimensions = json["dimensions"];
  if (!IsTriple(dimensions)) throw InputError(path, "dimensions: must be three whole numbers");
  for (int axis = 0; axis < 3; ++axis) {
    if (!origin[axis].is_number()) throw InputError(path, "origin: must be three numbers");
    mask.origin[axis] = origin[axis].get<double>();
    if (!dimensions[axis].is_number_unsigned() ||
        dimensions[axis].get<std::uint64_t>() - 1 >= kMaxDimension) {
      throw InputError(path, "dimensions: must be three whole numbers in [1, " +
                                 std::to_string(kMaxDimension) + "]");
    }
    mask.dimensions[axis] = dimensions[axis].get<int>();
  }
  const nlohmann::json& cell_size = json["cell_size"];
  if (!cell_size.is_number() || !(cell_size.get<double>() > 0)) {
    throw InputError(path, "cell_size: must be a number > 0");
  }
  mask.cell_size = cell_size.get<double>();
  const nlohmann::json& voxels = json["voxels"];
  if (!voxels.is_string()) throw InputError(path, "voxels: must be the name of a file");
  const std::filesystem::path voxel_path = path.parent_path() / voxels.get<std::string>();
  mask.voxels = ReadFileBytes(voxel_path);
  const std::int64_t expected =
      std::int64_t{mask.dimensions[0]} * mask.dimensions[1] * mask.dimensions[2];
  if (static_cast<std::int64_t>(mask.voxels.size()) != expected) {
    throw InputError(voxel_path, "has " + std::to_string(mask.voxels.size()) + " bytes, but " +
                                     Product(mask.dimensions) + " voxels of " + path.string() +
                                     " are " + std::to_string(expected));
  }
  return mask;
}

Eigen::Vector4d ReadPlane(const std::filesystem::path& path) {
  std::istringstream words(ReadFileBytes(path));
  Eigen::Vector4d plane;
  int count = 0;
  for (std::string word; words >> word; ++count) {
    if (count == 4) throw InputError(path, "plane: has more than four numbers");
    const auto parsed = std::from_chars(word.data(), word.data() + word.size(), plane[count]);
    if (parsed.ec != std::errc() || parsed.ptr != word.data() + word.size() ||
        !std::isfinite(plane[count])) {
      throw InputError(path, "plane: number " + std::to_string(count + 1) + " of a b c d is '" +
                                 word.substr(0, 40) + "'");
    }
  }
  if (count < 4) {
    throw InputError(path, "plane: has " + std::to_string(count) + " numbers, must be a b c d");
  }
  if (plane.head<3>().isZero(0)) throw InputError(path, "plane: a, b and c are all zero");
  return plane;
}

}  // namespace burin
