// Values of JSON files as readers want them, where nlohmann's own conversions wrap, truncate or are silent. What is
// not as wanted throws json::exception or std::out_of_range; readers make InputErrors of these.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

namespace burin {

// A whole number that fits.
template <typename T>
T Whole(const nlohmann::json& value) {
  if (!value.is_number_integer() ||
      (value.is_number_unsigned()
           ? value.get<uint64_t>() > static_cast<uint64_t>(std::numeric_limits<T>::max())
           : value.get<int64_t>() < static_cast<int64_t>(std::numeric_limits<T>::min()))) {
    throw std::out_of_range(value.dump() + " is not a whole number in range");
  }
  return value.get<T>();
}

inline Eigen::Vector3d Vector3(const nlohmann::json& value) {
  return {value.at(0).get<double>(), value.at(1).get<double>(), value.at(2).get<double>()};
}

// The number `key` of an object; `otherwise` when it has none.
inline double NumberOr(const nlohmann::json& object, const char* key, double otherwise) {
  const auto found = object.find(key);
  return found == object.end() ? otherwise : found->get<double>();
}

// Whether the file is JSON whose outermost object, or an object of its outermost array, has `key`. Reads only as far as
// that; false for what cannot be read or is not JSON up to there.
bool HasJsonKey(const std::filesystem::path& path, const std::string& key);

}  // namespace burin
