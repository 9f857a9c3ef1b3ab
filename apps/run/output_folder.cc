#include "apps/run/output_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "core/support/error.h"

namespace burin {

OutputFolder::OutputFolder(std::filesystem::path path) : path_(std::move(path)) {
  if (path_.empty()) throw InputError("--output: must name a folder");
  std::error_code error;
  for (std::filesystem::path missing = std::filesystem::absolute(path_).lexically_normal();
       !std::filesystem::exists(missing, error) && missing.has_relative_path();
       missing = missing.parent_path()) {
    if (missing.has_filename()) made_.push_back(missing);
  }
  std::filesystem::create_directories(path_, error);
  if (error) {
    RemoveEmpty();
    throw InputError(path_, "folder cannot be made: " + error.message());
  }
  if (access(path_.c_str(), W_OK | X_OK) != 0) {
    throw InputError(path_, std::string("folder cannot be written to: ") + std::strerror(errno));
  }
  lock_ = open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  // A file system without locks leaves the folder unlocked.
  if (lock_ >= 0 && flock(lock_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    close(lock_);
    throw InputError(path_, "another run of burin writes to this folder");
  }
}

OutputFolder::~OutputFolder() {
  RemoveEmpty();
  if (lock_ >= 0) close(lock_);
}

void OutputFolder::RemoveEmpty() const {
  std::error_code not_empty;
  for (const std::filesystem::path& folder : made_) {
    std::filesystem::remove(folder, not_empty);
  }
}

void RefuseToReplace(const std::string& named, const std::filesystem::path& input,
                     const std::vector<std::filesystem::path>& written) {
  for (const std::filesystem::path& path : written) {
    std::error_code error;
    if (std::filesystem::exists(path, error) && std::filesystem::equivalent(path, input, error)) {
      throw InputError(named + ": this run would write to " + path.string() +
                       ": name another --output");
    }
  }
}

}  // namespace burin
