#include "core/scene/formats/llff.h"

#include <Eigen/Core>
#include <cmath>
#include <string>
#include <vector>

#include "core/scene/formats/camera_checks.h"
#include "core/scene/formats/folder_files.h"
#include "core/scene/formats/numpy_file.h"
#include "core/support/error.h"
#include "core/support/file_bytes.h"

namespace burin {
namespace {

namespace fs = std::filesystem;

fs::path PosesFile(const fs::path& path) {
  return FileOrInFolder(path, ".npy", {"poses_bounds.npy"});
}

int Side(double side, const fs::path& file, const std::string& element) {
  if (!(side >= 1 && side <= 1e9)) {
    throw InputError(file, element + " = " + std::to_string(side) + ": must be pixels");
  }
  return static_cast<int>(std::lround(side));
}

}  // namespace

bool IsLlff(const fs::path& path) { return !PosesFile(path).empty(); }

PosedScene ReadLlff(const fs::path& path, const fs::path& images) {
  const fs::path file = PosesFile(path);
  const Eigen::MatrixXd rows = ParseNumpy(ReadFileBytes(file), file, "").Matrix();
  if (rows.cols() != 17) throw InputError(file, "shape: must be (N, 17)");
  const fs::path folder = images.empty() ? file.parent_path() / "images" : images;
  const std::vector<fs::path> photographs = PhotographsIn(folder);
  if (photographs.size() != static_cast<size_t>(rows.rows())) {
    throw InputError(folder, "has " + std::to_string(photographs.size()) + " photographs, but " +
                                 file.filename().string() + " has " + std::to_string(rows.rows()) +
                                 " cameras");
  }
  PosedScene posed;
  posed.file = file;
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    PosedImage& view = posed.images.emplace_back();
    view.image_path = photographs[i];
    view.name = view.image_path.filename().string();
    const Eigen::RowVectorXd row = rows.row(i).head(15);
    const Eigen::Matrix<double, 3, 5, Eigen::RowMajor> pose =
        Eigen::Map<const Eigen::Matrix<double, 3, 5, Eigen::RowMajor>>(row.data());
    const std::string element = "row " + std::to_string(i) + ": ";
    Eigen::Matrix3d rotation;
    rotation << pose.col(1).transpose(), pose.col(0).transpose(), -pose.col(2).transpose();
    view.camera.rotation = NearestRotation(rotation, file, element + "pose");
    view.camera.translation = -view.camera.rotation * pose.col(3);
    view.camera.height = Side(pose(0, 4), file, element + "height");
    view.camera.width = Side(pose(1, 4), file, element + "width");
    view.camera.fx = view.camera.fy = pose(2, 4);
    view.camera.cx = view.camera.width / 2.0;
    view.camera.cy = view.camera.height / 2.0;
  }
  return posed;
}

}  // namespace burin
