// TinyScene with its photographs on disk, for files of a format to be written beside, and what reading them must give.
#pragma once

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <string>

#include "tests/colmap_testing.h"

namespace burin {

class GivenScene : public testing::Test {
 protected:
  GivenScene() : scene_(TinyScene()) {
    for (const View& view : scene_.views) {
      std::filesystem::create_directories(Images());
      cv::imwrite((Images() / view.name).string(), view.gray);
    }
  }
  std::filesystem::path Folder() const { return folder_.path() / "scene"; }
  std::filesystem::path Images() const { return Folder() / "images"; }
  void WriteFile(const std::string& name, const std::string& text) const {
    WriteBytes(Folder() / name, text);
  }
  const Camera& CameraAt(int v) const { return scene_.views[v].camera; }

  // Cameras, photographs and, where the format has them, points are those of scene_. Formats write single precision or few
  // digits: `pixels` of tolerance.
  void ExpectScene(const Scene& scene, bool points, double pixels = 1e-8) const {
    ASSERT_EQ(scene.views.size(), scene_.views.size());
    for (size_t v = 0; v < scene.views.size(); ++v) {
      EXPECT_EQ(scene.views[v].name, names_below_ + scene_.views[v].name);
      const Camera& camera = scene.views[v].camera;
      const Camera& given = CameraAt(static_cast<int>(v));
      EXPECT_EQ(camera.width, given.width);
      EXPECT_EQ(camera.height, given.height);
      for (const ScenePoint& point : scene_.points) {
        EXPECT_LT((camera.Project(point.position) - given.Project(point.position)).norm(), pixels);
        EXPECT_NEAR(camera.Depth(point.position), given.Depth(point.position), pixels);
      }
      EXPECT_EQ(cv::norm(scene.views[v].gray, scene_.views[v].gray, cv::NORM_INF), 0);
    }
    ASSERT_EQ(scene.points.size(), points ? scene_.points.size() : 0);
    for (size_t p = 0; p < scene.points.size(); ++p) {
      EXPECT_LT((scene.points[p].position - scene_.points[p].position).norm(), 1e-6);
      EXPECT_EQ(scene.points[p].views, scene_.points[p].views);
    }
  }

  Scene scene_;
  std::string names_below_;  // before the names of scene_, in the format's
  TempFolder folder_;
};

}  // namespace burin
