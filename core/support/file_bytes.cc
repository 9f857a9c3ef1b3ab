#include "core/support/file_bytes.h"

#include <fstream>
#include <system_error>

#include "core/support/error.h"

namespace burin {

std::string ReadFileBytes(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) throw InputError(path, "file is missing");
  if (!std::filesystem::is_regular_file(path, error)) throw InputError(path, "is not a file");
  const std::uintmax_t length = std::filesystem::file_size(path, error);
  std::ifstream file(path, std::ios::binary);
  if (error || !file) throw InputError(path, "cannot be read");
  std::string bytes(length, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(length));
  if (static_cast<std::uintmax_t>(file.gcount()) != length) {
    throw InputError(path, "cannot be read to its end");
  }
  return bytes;
}

}  // namespace burin
