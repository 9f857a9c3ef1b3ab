// Errors a user can cause. Readers, writers and the pipeline throw InputError; the command line
// turns it into one line on standard error and exit code 2. Bugs are CHECKs, never InputError.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

namespace burin {

class InputError : public std::runtime_error {
 public:
  explicit InputError(const std::string& message) : std::runtime_error(OneLine(message)) {}
  // "path: reason"; the reason names the field or element, what it is, and what it must be.
  InputError(const std::filesystem::path& path, const std::string& reason)
      : InputError(path.string() + ": " + reason) {}

 private:
  // Messages quote what files hold: control characters, of which NUL would end the message, are blanks.
  static std::string OneLine(std::string message) {
    for (char& c : message) {
      if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
    }
    return message;
  }
};

}  // namespace burin
