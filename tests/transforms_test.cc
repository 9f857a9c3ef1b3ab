// transforms.json gives the cameras that the file was made of, as nerfstudio, instant-ngp and Blender's scenes write it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "tests/given_scene.h"

namespace burin {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

// World from camera with y up and z backwards.
json OpenGl(const Camera& camera) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = camera.rotation.transpose() * Eigen::Vector3d(1, -1, -1).asDiagonal();
  m.topRightCorner<3, 1>() = camera.Center();
  json rows;
  for (int r = 0; r < 4; ++r) rows.push_back({m(r, 0), m(r, 1), m(r, 2), m(r, 3)});
  return rows;
}

class Transforms : public GivenScene {
 protected:
  Transforms() { names_below_ = "images/"; }
  // A frame with its own intrinsics for every view.
  json Given() const {
    json root = {{"camera_model", "OPENCV"},
                 {"applied_transform", {{1, 0, 0, 0}, {0, 0, 1, 0}, {0, -1, 0, 0}}},
                 {"ply_file_path", "sparse_pc.ply"}};
    for (const View& view : scene_.views) {
      const Camera& c = view.camera;
      root["frames"].push_back({{"file_path", "images/" + view.name},
                                {"fl_x", c.fx},
                                {"fl_y", c.fy},
                                {"cx", c.cx},
                                {"cy", c.cy},
                                {"w", 6},
                                {"h", 4.0},
                                {"transform_matrix", OpenGl(c)}});
    }
    return root;
  }
  std::string ErrorOf(const json& root) const {
    WriteFile("transforms.json", root.dump());
    return LoadError(Folder());
  }
};

TEST_F(Transforms, Nerfstudio) {
  const json root = Given();
  WriteFile("transforms.json", root.dump());
  EXPECT_EQ(FormatOf(Folder()), "Transforms");
  ExpectScene(LoadScene({Folder() / "transforms.json", Images(), {}}), false);
  ExpectScene(LoadScene({Folder(), {}, {}}), false);
}

TEST_F(Transforms, OneCameraForAllWithALens) {
  scene_.views[1].camera.fx = scene_.views[0].camera.fx;
  scene_.views[1].camera.cy = scene_.views[0].camera.cy;
  json root = Given();
  for (const char* field : {"fl_x", "fl_y", "cx", "cy", "w", "h"}) {
    root[field] = root["frames"][0][field];
    for (json& frame : root["frames"]) frame.erase(field);
  }
  WriteFile("one.json", root.dump());
  ExpectScene(LoadScene({Folder() / "one.json", {}, {}}), false);
  root["k1"] = 0.01;
  root["p1"] = 0.003;
  root["frames"][1]["k1"] = 0.02;
  root["frames"][1]["k2"] = -0.01;
  root["k3"] = 0.005;
  root["p2"] = 0.004;
  root["k4"] = 0;
  WriteFile("one.json", root.dump());
  const PosedScene posed = ReadScene({Folder() / "one.json", {}, {}});
  EXPECT_EQ(posed.images[0].lens.brown, (std::array<double, 5>{0.01, 0, 0.003, 0.004, 0.005}));
  EXPECT_EQ(posed.images[1].lens.brown, (std::array<double, 5>{0.02, -0.01, 0.003, 0.004, 0.005}));
}

// Angles of view, names without extension, the principal point in the middle.
TEST_F(Transforms, Blender) {
  for (View& view : scene_.views) {
    view.camera.fx = view.camera.fy = scene_.views[0].camera.fx;
    view.camera.cx = 3;
    view.camera.cy = 2;
  }
  json root = {{"camera_angle_x", 2 * std::atan(3 / scene_.views[0].camera.fx)}};
  for (int v = 0; v < 2; ++v) {
    root["frames"].push_back({{"file_path", "./images/view" + std::to_string(v)},
                              {"rotation", 0.0125},
                              {"transform_matrix", OpenGl(scene_.views[v].camera)}});
  }
  WriteFile("transforms_train.json", root.dump());
  ExpectScene(LoadScene({Folder(), {}, {}}), false);
  ExpectScene(LoadScene({Folder(), Images(), {}}), false);
  root.erase("camera_angle_x");
  root["x_fov"] = 360 / M_PI * std::atan(3 / scene_.views[0].camera.fx);
  WriteFile("transforms_train.json", root.dump());
  ExpectScene(LoadScene({Folder(), {}, {}}), false);
}

TEST_F(Transforms, MasksOfFrames) {
  json root = Given();
  cv::Mat mask(4, 6, CV_8UC1, cv::Scalar(255));
  mask.at<uchar>(1, 2) = 0;
  fs::create_directories(Folder() / "masks");
  cv::imwrite((Folder() / "masks/0.png").string(), mask);
  root["frames"][0]["mask_path"] = "masks/0.png";
  WriteFile("transforms.json", root.dump());
  const Scene scene = LoadScene({Folder(), {}, {}});
  EXPECT_EQ(cv::countNonZero(scene.views[0].mask), 23);
  EXPECT_EQ(scene.views[0].mask.at<uchar>(1, 2), 0);
  EXPECT_TRUE(scene.views[1].mask.empty());
}

TEST_F(Transforms, FramesWithoutPhotographsAreLeftOutWithALine) {
  json root = Given();
  json lost = root["frames"][0];
  lost["file_path"] = "images/lost.png";
  root["frames"].insert(root["frames"].begin() + 1, lost);
  WriteFile("transforms.json", root.dump());
  const Scene scene = LoadScene({Folder(), {}, {}});
  ExpectScene(scene, false);
  EXPECT_THAT(scene.notes,
              testing::ElementsAre("1 of 3 frames left out: their photographs are missing; the "
                                   "first is images/lost.png"));
}

TEST_F(Transforms, WhatIsWrongIsNamed) {
  const json good = Given();
  const auto with = [&](const char* field, const json& value) {
    json root = good;
    root["frames"][1][field] = value;
    return ErrorOf(root);
  };
  EXPECT_THAT(with("camera_model", "OPENCV_FISHEYE"),
              HasSubstr("frame images/view1.png: camera_model 'OPENCV_FISHEYE' is not supported"));
  EXPECT_THAT(with("is_fisheye", true), HasSubstr("view1.png: is_fisheye is not supported"));
  EXPECT_THAT(with("k4", 0.1), HasSubstr("view1.png: k4 is not supported"));
  EXPECT_THAT(with("w", 6.5), HasSubstr("view1.png: w = 6.5: must be a whole number of pixels"));
  EXPECT_THAT(with("w", 1e300), HasSubstr("must be a whole number of pixels"));
  EXPECT_THAT(with("file_path", "images/lost"), HasSubstr("photograph images/lost: is in none of"));
  EXPECT_THAT(with("file_path", 7), HasSubstr("is no transforms.json as it should be"));
  EXPECT_THAT(with("transform_matrix", {{1, 0, 0}, {0, 1, 0}}),
              HasSubstr("is no transforms.json as it should be"));
  json matrix = good["frames"][1]["transform_matrix"];
  matrix[3][3] = 2;
  EXPECT_THAT(with("transform_matrix", matrix), HasSubstr("its last row must be 0 0 0 1"));
  matrix = good["frames"][1]["transform_matrix"];
  for (int r = 0; r < 3; ++r) matrix[r][0] = -matrix[r][0].get<double>();
  EXPECT_THAT(with("transform_matrix", matrix), HasSubstr("view1.png: transform_matrix: "));
  json root = good;
  root["frames"][1].erase("fl_x");
  root["frames"][1].erase("fl_y");
  EXPECT_THAT(ErrorOf(root), HasSubstr("view1.png: fl_x: is missing, and so is camera_angle_x"));
  WriteFile("other.json", "{\"sfm\": {\"frames\": 2}}");
  EXPECT_THAT(LoadError(Folder() / "other.json"),
              HasSubstr("is no scene in JSON that burin knows"));
}

}  // namespace
}  // namespace burin
