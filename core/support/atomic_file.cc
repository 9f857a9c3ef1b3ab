#include "core/support/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <fstream>
#include <system_error>

#include "core/support/error.h"

namespace burin {
namespace {

constexpr char kMark[] = ".burin-tmp";

void WriteWhole(const std::filesystem::path& path, const std::string& text,
                const std::filesystem::path& target) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (!file) throw InputError(target, "cannot be written");
}

// A file, or the entries of a folder. Some file systems cannot: then there is nothing more to do.
void Sync(const std::filesystem::path& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return;
  fsync(descriptor);
  close(descriptor);
}

}  // namespace

void MakeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw InputError(folder, "folder cannot be made: " + error.message());
}

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
  WriteAtomically(
      target, [&](const std::filesystem::path& temporary) { WriteWhole(temporary, text, target); });
}

void WriteTextDurably(const std::filesystem::path& target, const std::string& text) {
  WriteAtomically(target, [&](const std::filesystem::path& temporary) {
    WriteWhole(temporary, text, target);
    Sync(temporary);
  });
  Sync(std::filesystem::absolute(target).parent_path());
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
