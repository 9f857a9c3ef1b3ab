// JSON files that burin reads, with their errors as lines for the user, and JSON that it writes.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace burin {

// The file's value. Throws InputError when it cannot be read, is not JSON (with the byte), or has a
// number that no double holds.
nlohmann::json ReadJsonFile(const std::filesystem::path& path);

// To four decimals; null for what is not finite.
nlohmann::ordered_json RoundedOrNull(double value);

// Indented, with a line end. Bytes that are not UTF-8, which names of files may have, are U+FFFD.
std::string JsonText(const nlohmann::json& json);
std::string JsonText(const nlohmann::ordered_json& json);

}  // namespace burin
