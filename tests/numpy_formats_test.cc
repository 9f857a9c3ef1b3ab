// Cameras in NumPy's files, LLFF's and NeuS's: those that the files were made of, by the formats' own formulas.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zip.h>

#include <cstring>
#include <map>
#include <string>

#include "core/scene/formats/numpy_file.h"
#include "tests/given_scene.h"

namespace burin {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

std::string Npy(const Eigen::MatrixXd& matrix, bool fortran = false) {
  std::string header =
      "{'descr': '<f8', 'fortran_order': " + std::string(fortran ? "True" : "False") +
      ", 'shape': (" + std::to_string(matrix.rows()) + ", " + std::to_string(matrix.cols()) +
      "), }\n";
  std::string bytes("\x93NUMPY\x01\x00", 8);
  bytes += static_cast<char>(header.size());
  bytes += '\0';
  bytes += header;
  const Eigen::MatrixXd ordered = fortran ? matrix : matrix.transpose();  // Eigen's are by columns
  const size_t begin = bytes.size();
  bytes.resize(begin + 8 * ordered.size());
  std::memcpy(bytes.data() + begin, ordered.data(), 8 * ordered.size());
  return bytes;
}

void WriteZip(const fs::path& path, const std::map<std::string, std::string>& files) {
  fs::create_directories(path.parent_path());
  zip_t* archive = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, nullptr);
  for (const auto& [name, bytes] : files) {
    zip_file_add(archive, name.c_str(), zip_source_buffer(archive, bytes.data(), bytes.size(), 0),
                 ZIP_FL_OVERWRITE);
  }
  ASSERT_EQ(zip_close(archive), 0);
}

std::string ParseError(const std::string& bytes) {
  try {
    ParseNumpy(bytes, "a.npy", "");
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(NumpyFile, EitherOrderAndWhatIsWrong) {
  Eigen::MatrixXd matrix(2, 3);
  matrix << 1, 2, 3, 4, 5, -6e-7;
  EXPECT_EQ(ParseNumpy(Npy(matrix), "a.npy", "").Matrix(), matrix);
  EXPECT_EQ(ParseNumpy(Npy(matrix, true), "a.npy", "").Matrix(), matrix);
  std::string bytes = Npy(matrix);
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string changed = bytes;
    return changed.replace(changed.find(from), from.size(), to);
  };
  EXPECT_EQ(ParseNumpy(with("'<f8'", "'|u1'"), "a.npy", "").values, std::vector<double>(6, 0));
  EXPECT_THAT(ParseError(with("'<f8'", "'>f8'")), HasSubstr("descr '>f8' is not supported"));
  EXPECT_THAT(ParseError(with("(2, 3)", "(9, 3)")), HasSubstr("the array is truncated"));
  EXPECT_THAT(ParseError(with("(2, 3)", "(9,99)")), HasSubstr("no room for it"));
  EXPECT_THAT(ParseError(bytes.substr(0, bytes.size() - 1)), HasSubstr("the array is truncated"));
  EXPECT_THAT(ParseError(bytes.substr(0, 20)), HasSubstr("the header is truncated"));
  EXPECT_THAT(ParseError("PK"), HasSubstr("is no array of NumPy"));
  matrix(1, 1) = std::numeric_limits<double>::infinity();
  EXPECT_THAT(ParseError(Npy(matrix)), HasSubstr("not finite"));
}

class NumpyFormats : public GivenScene {};

TEST_F(NumpyFormats, Llff) {
  Eigen::MatrixXd rows(2, 17);
  for (int v = 0; v < 2; ++v) {
    Camera& c = scene_.views[v].camera;
    c.fy = c.fx;
    c.cx = 3;
    c.cy = 2;
    const Eigen::Matrix3d axes = c.rotation.transpose();  // right, down, forward
    Eigen::Matrix<double, 3, 5, Eigen::RowMajor> pose;
    pose << axes.col(1), axes.col(0), -axes.col(2), c.Center(), Eigen::Vector3d(4, 6, c.fx);
    rows.row(v) << Eigen::Map<Eigen::RowVectorXd>(pose.data(), 15), 1.5, 20;
  }
  WriteFile("poses_bounds.npy", Npy(rows));
  EXPECT_EQ(FormatOf(Folder()), "LLFF");
  ExpectScene(LoadScene({Folder(), {}, {}}), false);
  ExpectScene(LoadScene({Folder() / "poses_bounds.npy", Images(), {}}), false);
  // Photographs of half the size have half the focal length.
  for (const View& view : scene_.views) {
    fs::create_directories(Folder() / "images_2");
    cv::imwrite((Folder() / "images_2" / view.name).string(),
                cv::Mat(2, 3, CV_8UC1, cv::Scalar(9)));
  }
  const Scene half = LoadScene({Folder(), Folder() / "images_2", {}});
  EXPECT_NEAR(half.views[0].camera.fx, CameraAt(0).fx / 2, 1e-12);
  EXPECT_EQ(half.views[0].camera.cx, 1.5);
  cv::imwrite((Images() / "third.png").string(), scene_.views[0].gray);
  EXPECT_THAT(LoadError(Folder()),
              HasSubstr("images: has 3 photographs, but poses_bounds.npy has 2 cameras"));
  fs::remove(Images() / "third.png");
  rows(1, 0) += 0.1;
  WriteFile("poses_bounds.npy", Npy(rows));
  EXPECT_THAT(LoadError(Folder()), HasSubstr("poses_bounds.npy: row 1: pose: "));
  rows(0, 4) = 0;
  WriteFile("poses_bounds.npy", Npy(rows));
  EXPECT_THAT(LoadError(Folder()), HasSubstr("row 0: height = 0.000000: must be pixels"));
  WriteFile("poses_bounds.npy", Npy(rows.leftCols(15)));
  EXPECT_THAT(LoadError(Folder()), HasSubstr("shape: must be (N, 17)"));
}

TEST_F(NumpyFormats, Neus) {
  fs::rename(Images(), Folder() / "image");
  std::map<std::string, std::string> files;
  for (int v = 0; v < 2; ++v) {
    const Camera& c = CameraAt(v);
    Eigen::Matrix4d world = Eigen::Matrix4d::Identity();
    Eigen::Matrix3d k = Eigen::Matrix3d::Identity();
    k << c.fx, 0, c.cx - 0.5, 0, c.fy, c.cy - 0.5, 0, 0, 1;
    world.topLeftCorner<3, 3>() = k * c.rotation;
    world.topRightCorner<3, 1>() = k * c.translation;
    const std::string i = std::to_string(v);
    files["world_mat_" + i + ".npy"] = Npy(world, v == 1);
    files["world_mat_inv_" + i + ".npy"] = Npy(world.inverse());
    files["scale_mat_" + i + ".npy"] = Npy(3.0 * Eigen::Matrix4d::Identity());
    cv::Mat mask(4, 6, CV_8UC1, cv::Scalar(255));
    mask.at<uchar>(v, 0) = 0;
    fs::create_directories(Folder() / "mask");
    cv::imwrite((Folder() / "mask" / (i + ".png")).string(), mask);
  }
  WriteZip(Folder() / "cameras_sphere.npz", files);
  EXPECT_EQ(FormatOf(Folder()), "NeuS");
  const Scene scene = LoadScene({Folder(), {}, {}});
  ExpectScene(scene, false);
  EXPECT_EQ(scene.views[1].mask.at<uchar>(1, 0), 0);
  EXPECT_EQ(cv::countNonZero(scene.views[1].mask), 23);
  ExpectScene(LoadScene({Folder() / "cameras_sphere.npz", Folder() / "image", {}}), false);
  files.erase("world_mat_0.npy");
  files["world_mat_7.npy"] = files["world_mat_1.npy"];
  WriteZip(Folder() / "cameras_sphere.npz", files);
  EXPECT_THAT(LoadError(Folder()), HasSubstr("cameras_sphere.npz: world_mat_0: is missing"));
  files["world_mat_0.npy"] = "PK";
  WriteZip(Folder() / "cameras_sphere.npz", files);
  EXPECT_THAT(LoadError(Folder()), HasSubstr("world_mat_0: is no array of NumPy"));
  WriteFile("cameras_sphere.npz", "none");
  EXPECT_THAT(LoadError(Folder()), HasSubstr("is no archive of NumPy (zip)"));
}

}  // namespace
}  // namespace burin
