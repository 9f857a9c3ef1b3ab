#include "apps/run/cameras_folder.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

#include "core/scene/formats/colmap_model.h"
#include "core/support/error.h"

namespace burin {
namespace {

namespace fs = std::filesystem;

}  // namespace

std::vector<fs::path> CamerasFolders(const fs::path& output) {
  return {output / "cameras", output / "cameras" / "sparse"};
}

void CheckCamerasFolders(const fs::path& output) {
  for (const fs::path& folder : CamerasFolders(output)) {
    std::error_code error;
    const fs::file_status status = fs::symlink_status(folder, error);
    if (!fs::exists(status)) return;
    if (!fs::is_directory(folder, error)) {
      throw InputError(folder, "is not a folder: this run would write its cameras there");
    }
    if (access(folder.c_str(), W_OK | X_OK) != 0) {
      throw InputError(folder, std::string("folder cannot be written to: ") + std::strerror(errno));
    }
  }
}

void RemoveCameras(const fs::path& output) {
  const std::vector<fs::path> folders = CamerasFolders(output);
  const ColmapFiles files = ColmapFilesIn(folders.back(), /*binary=*/false);
  bool removed = false;
  for (const fs::path& file : {files.cameras, files.images, files.points}) {
    std::error_code error;
    if (!fs::is_regular_file(file, error)) continue;
    if (!fs::remove(file, error)) {
      throw InputError(file, "cameras of an earlier run cannot be removed: " + error.message());
    }
    removed = true;
  }
  if (!removed) return;
  for (auto folder = folders.rbegin(); folder != folders.rend(); ++folder) {
    std::error_code not_empty;
    if (!fs::is_symlink(*folder, not_empty)) fs::remove(*folder, not_empty);
  }
}

}  // namespace burin
