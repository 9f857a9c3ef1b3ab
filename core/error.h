// Errors a user can cause. Readers, writers and the pipeline throw InputError; the command line
// turns it into one line on standard error and exit code 2. Bugs are CHECKs, never InputError.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

namespace burin {

class InputError : public std::runtime_error {
 public:
  explicit InputError(const std::string& message) : std::runtime_error(message) {}
  // "path: reason"; the reason names the field or element, what it is, and what it must be.
  InputError(const std::filesystem::path& path, const std::string& reason)
      : std::runtime_error(path.string() + ": " + reason) {}
};

}  // namespace burin
