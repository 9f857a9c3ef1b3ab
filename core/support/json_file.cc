#include "core/support/json_file.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/support/error.h"
#include "core/support/file_bytes.h"

namespace burin {

nlohmann::json ReadJsonFile(const std::filesystem::path& path) {
  try {
    return nlohmann::json::parse(ReadFileBytes(path));
  } catch (const nlohmann::json::parse_error& error) {
    throw InputError(path, "byte " + std::to_string(error.byte) + ": not valid JSON");
  } catch (const nlohmann::json::out_of_range&) {
    throw InputError(path, "has a number too large for a double");
  }
}

namespace {

template <typename Json>
std::string Text(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

nlohmann::ordered_json RoundedOrNull(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(std::round(value * 1e4) / 1e4)
                              : nlohmann::ordered_json();
}

std::string JsonText(const nlohmann::json& json) { return Text(json); }
std::string JsonText(const nlohmann::ordered_json& json) { return Text(json); }

}  // namespace burin
