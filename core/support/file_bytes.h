// Input files are read whole and then parsed from memory, so that every count in them can be
// compared with what is there.
#pragma once

#include <filesystem>
#include <string>

namespace burin {

// The whole file. Throws InputError when it is missing or cannot be read.
std::string ReadFileBytes(const std::filesystem::path& path);

}  // namespace burin
