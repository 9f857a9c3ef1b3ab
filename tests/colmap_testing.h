// What the COLMAP tests share: a folder that goes away, files in it, a scene small enough to read.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "core/scene/formats/colmap.h"
#include "core/scene/formats/scene_loader.h"
#include "core/support/error.h"
#include "core/support/file_bytes.h"

namespace burin {

// A folder of its own for each test, removed at its end.
class TempFolder {
 public:
  TempFolder() {
    const testing::TestInfo* info = testing::UnitTest::GetInstance()->current_test_info();
    path_ = std::filesystem::temp_directory_path() /
            ("burin_" + std::string(info->test_suite_name()) + "_" + info->name() + "_" +
             std::to_string(getpid()));
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~TempFolder() { std::filesystem::remove_all(path_); }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline void WriteBytes(const std::filesystem::path& path, const std::string& bytes) {
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << bytes;
}

// Two 6 x 4 views with different cameras, three points, one of them with digits to lose.
inline Scene TinyScene() {
  Scene scene;
  for (int v = 0; v < 2; ++v) {
    View& view = scene.views.emplace_back();
    view.name = "view" + std::to_string(v) + ".png";
    Camera& camera = view.camera;
    camera.width = 6;
    camera.height = 4;
    camera.fx = 5 + v / 3.0;
    camera.fy = 5.1;
    camera.cx = 3.05;
    camera.cy = 2 - v / 7.0;
    camera.rotation =
        Eigen::AngleAxisd(0.1 + 2.9 * v, Eigen::Vector3d(1, -2, 3).normalized()).matrix();
    camera.translation = {0.1 - v, 1.0 / 3, 9.0 + v};
    view.gray = cv::Mat(4, 6, CV_8UC1);
    for (int i = 0; i < 24; ++i) view.gray.data[i] = static_cast<unsigned char>(10 * i + v);
  }
  scene.points = {{{0, 0, 0}, {0, 1}}, {{0.1, -1.0 / 3, 1e-7}, {0, 1}}, {{-1, 0.5, 0.25}, {0, 1}}};
  return scene;
}

// The message of the InputError that loading gives; checks that it is one line.
inline std::string LoadError(const std::filesystem::path& workspace) {
  try {
    LoadScene({workspace, {}, {}});
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    return message;
  }
  return "no error";
}

}  // namespace burin
