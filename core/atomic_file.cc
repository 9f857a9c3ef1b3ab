#include "core/atomic_file.h"

#include <unistd.h>

#include <fstream>
#include <system_error>

#include "core/error.h"

namespace burin {
namespace {

constexpr char kMark[] = ".burin-tmp";

}  // namespace

void WriteAtomically(const std::filesystem::path& target,
                     const std::function<void(const std::filesystem::path&)>& write) {
  std::filesystem::path temporary = target;
  temporary.replace_filename("." + target.stem().string() + kMark + std::to_string(getpid()) +
                             target.extension().string());
  std::error_code error;
  try {
    write(temporary);
  } catch (...) {
    std::filesystem::remove(temporary, error);
    throw;
  }
  std::filesystem::rename(temporary, target, error);
  if (error) {
    const std::string reason = error.message();
    std::filesystem::remove(temporary, error);
    throw InputError(target, "cannot be written: " + reason);
  }
}

void WriteTextAtomically(const std::filesystem::path& target, const std::string& text) {
  WriteAtomically(target, [&](const std::filesystem::path& temporary) {
    std::ofstream file(temporary, std::ios::binary);
    file << text;
    file.close();
    if (!file) throw InputError(target, "cannot be written");
  });
}

void RemoveTemporaries(const std::filesystem::path& folder) {
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (name[0] == '.' && name.find(kMark) != std::string::npos) {
      std::filesystem::remove(entry.path(), error);
    }
  }
}

}  // namespace burin
