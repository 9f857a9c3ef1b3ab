#include "core/scene/formats/neus.h"

#include <Eigen/Core>
#include <map>
#include <string>
#include <system_error>
#include <vector>

#include "core/scene/formats/folder_files.h"
#include "core/scene/formats/numpy_file.h"
#include "core/support/error.h"

namespace burin {
namespace {

namespace fs = std::filesystem;

constexpr char kMatrix[] = "world_mat_";

fs::path CamerasFile(const fs::path& path) {
  return FileOrInFolder(path, ".npz", {"cameras_sphere.npz", "cameras.npz"});
}

bool IsWorldMatrix(const std::string& name) {
  return name.rfind(kMatrix, 0) == 0 && name.find("inv") == std::string::npos;
}

fs::path FirstFolder(const fs::path& beside, const std::vector<const char*>& names) {
  for (const char* name : names) {
    std::error_code error;
    if (fs::is_directory(beside / name, error)) return beside / name;
  }
  return {};
}

}  // namespace

bool IsNeus(const fs::path& path) { return !CamerasFile(path).empty(); }

PosedScene ReadNeus(const fs::path& path, const fs::path& images) {
  const fs::path file = CamerasFile(path);
  const std::map<std::string, NumpyArray> matrices = ReadNumpyArchive(file, IsWorldMatrix);
  const fs::path beside = file.parent_path();
  const fs::path folder = images.empty() ? FirstFolder(beside, {"image", "images", "rgb"}) : images;
  if (folder.empty()) {
    throw InputError(file, "image/ is not beside it; --images DIR says where photographs are");
  }
  const std::vector<fs::path> photographs = PhotographsIn(folder);
  if (photographs.size() > matrices.size()) {
    throw InputError(folder, "has " + std::to_string(photographs.size()) + " photographs, but " +
                                 file.filename().string() + " has " +
                                 std::to_string(matrices.size()) + " cameras");
  }
  std::vector<fs::path> masks = PhotographsIn(FirstFolder(beside, {"mask", "masks"}));
  if (masks.size() != photographs.size()) masks.clear();
  const std::vector<cv::Size> sizes = PhotographSizes(photographs);
  PosedScene posed;
  posed.file = file;
  for (size_t i = 0; i < photographs.size(); ++i) {
    const std::string name = kMatrix + std::to_string(i);
    const auto found = matrices.find(name);
    if (found == matrices.end()) throw InputError(file, name + ": is missing");
    const Eigen::MatrixXd matrix = found->second.Matrix();
    if (matrix.cols() != 4 || matrix.rows() < 3 || matrix.rows() > 4) {
      throw InputError(file, name + ": shape: must be (4, 4) or (3, 4)");
    }
    PosedImage& view = posed.images.emplace_back();
    view.image_path = photographs[i];
    view.name = view.image_path.filename().string();
    if (!masks.empty()) view.mask_path = masks[i];
    view.camera = CameraOfProjection(matrix.topRows<3>(), sizes[i], file, name);
  }
  return posed;
}

}  // namespace burin
