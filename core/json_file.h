// JSON files that burin reads, with their errors as lines for the user.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

namespace burin {

// The file's value. Throws InputError when it cannot be read, is not JSON (with the byte), or has a
// number that no double holds.
nlohmann::json ReadJsonFile(const std::filesystem::path& path);

}  // namespace burin
