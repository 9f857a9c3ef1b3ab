// cameras.sfm gives the cameras, points and measurements that it was made of, in every version's way of writing them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <iomanip>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "tests/given_scene.h"
#include "tests/measured_scene.h"

namespace burin {
namespace {

using nlohmann::json;
using testing::HasSubstr;

std::string Digits(double value) {
  std::ostringstream text;
  text << std::setprecision(17) << value;
  return text.str();
}

json Pose(const Camera& camera) {
  json rotation;
  for (int k = 0; k < 9; ++k) rotation.push_back(Digits(camera.rotation(k % 3, k / 3)));
  const Eigen::Vector3d c = camera.Center();
  return {{"transform",
           {{"rotation", rotation}, {"center", {Digits(c.x()), Digits(c.y()), Digits(c.z())}}}},
          {"locked", "0"}};
}

class Meshroom : public GivenScene {
 protected:
  json Given(int minor, int patch) const {
    json root = {{"version", {"1", std::to_string(minor), std::to_string(patch)}}};
    const auto before = [&](int m, int p) { return minor < m || (minor == m && patch < p); };
    for (int v = 0; v < 2; ++v) {
      const Camera& c = CameraAt(v);
      const std::string id = std::to_string(1000000007 + v);
      root["views"].push_back({{"viewId", id},
                               {"poseId", id},
                               {"intrinsicId", id},
                               {"path", "/elsewhere/" + scene_.views[v].name},
                               {"width", "6"},
                               {"height", "4"}});
      json intrinsic = {{"intrinsicId", id},
                        {"width", "6"},
                        {"height", "4"},
                        {"type", "pinhole"},
                        {"distortionParams", ""}};
      const double middle = before(2, 1) ? 0 : 1;
      intrinsic["principalPoint"] = {Digits(c.cx - 0.5 - 3 * middle),
                                     Digits(c.cy - 0.5 - 2 * middle)};
      if (before(2, 0)) {
        intrinsic["pxFocalLength"] = Digits(c.fx);
      } else if (before(2, 2)) {
        intrinsic["pxFocalLength"] = {Digits(c.fx), Digits(c.fy)};
      } else {
        intrinsic["sensorWidth"] = "24";
        intrinsic["focalLength"] = Digits(c.fx * 24 / 6);
        intrinsic["pixelRatio"] = Digits(before(2, 5) ? c.fx / c.fy : c.fy / c.fx);
      }
      root["intrinsics"].push_back(intrinsic);
      root["poses"].push_back({{"poseId", id}, {"pose", Pose(c)}});
    }
    root["views"].push_back({{"viewId", "3"}, {"path", "/elsewhere/lost.png"}});
    for (const ScenePoint& point : scene_.points) {
      const Eigen::Vector3d& x = point.position;
      root["structure"].push_back(
          {{"landmarkId", "5"},
           {"X", {Digits(x.x()), Digits(x.y()), Digits(x.z())}},
           {"observations",
            {{{"observationId", "1000000007"}, {"featureId", "3"}, {"x", {"1", "2.5"}}},
             {{"observationId", "1000000008"}, {"featureId", "4"}, {"x", {"1", "2"}}}}}});
    }
    return root;
  }
  std::string ErrorOf(const json& root) const {
    WriteFile("cameras.sfm", root.dump());
    return LoadError(Folder());
  }
};

TEST_F(Meshroom, EveryVersion) {
  for (const auto& [minor, patch] : {std::pair(0, 0), {2, 0}, {2, 1}, {2, 2}, {2, 5}, {2, 11}}) {
    SCOPED_TRACE(std::to_string(minor) + "." + std::to_string(patch));
    scene_ = TinyScene();
    if (minor == 0) {
      for (View& view : scene_.views) view.camera.fy = view.camera.fx;
    }
    WriteFile("cameras.sfm", Given(minor, patch).dump());
    EXPECT_EQ(FormatOf(Folder()), "Meshroom");
    const Scene scene = LoadScene({Folder(), {}, {}});
    ExpectScene(scene, true);
    EXPECT_THAT(scene.notes,
                testing::ElementsAre(HasSubstr("1 of 3 views left out: they have no pose")));
    EXPECT_EQ(scene.tracks.Of(0).begin()->image_point, Eigen::Vector2d(1.5, 3));
    WriteFile("other.json", Given(minor, patch).dump());
    ExpectScene(LoadScene({Folder() / "other.json", Images(), {}}), true);
  }
}

TEST_F(Meshroom, Lenses) {
  const auto lens = [&](const std::string& type, const std::string& distortion) {
    json root = Given(2, 11);
    for (json& intrinsic : root["intrinsics"]) {
      intrinsic["type"] = type;
      if (!distortion.empty()) intrinsic["distortionType"] = distortion;
      intrinsic["distortionParams"] = {"0.1", "0.2", "0.3", "0.4", "0.5"};
    }
    WriteFile("cameras.sfm", root.dump());
    return ReadScene({Folder(), {}, {}}).images[0].lens.brown;
  };
  using Brown = std::array<double, 5>;
  EXPECT_EQ(lens("radial1", ""), (Brown{0.1, 0, 0, 0, 0}));
  EXPECT_EQ(lens("radial3", ""), (Brown{0.1, 0.2, 0, 0, 0.3}));
  EXPECT_EQ(lens("pinhole", "radialk3"), (Brown{0.1, 0.2, 0, 0, 0.3}));
  EXPECT_EQ(lens("brown", ""), (Brown{0.1, 0.2, 0.4, 0.5, 0.3}));
  EXPECT_EQ(lens("pinhole", "none"), (Brown{0, 0, 0, 0, 0}));
}

// Measurements are where the file has them, through the lens.
TEST(MeshroomTracks, AreWhereTheLensPhotographsThePoints) {
  const TempFolder folder;
  const Scene scene = MeasuredScene();
  const Lens lens{{-0.2, 0.05, 0, 0, 0.01}};
  json root = {{"version", {"1", "2", "1"}}};
  root["intrinsics"].push_back({{"intrinsicId", "9"},
                                {"width", "320"},
                                {"height", "240"},
                                {"type", "radial3"},
                                {"pxFocalLength", {"300", "300"}},
                                {"principalPoint", {"-0.5", "-0.5"}},
                                {"distortionParams", {"-0.2", "0.05", "0.01"}}});
  for (size_t v = 0; v < scene.views.size(); ++v) {
    const std::string id = std::to_string(v);
    cv::imwrite((folder.path() / scene.views[v].name).string(), scene.views[v].gray);
    root["views"].push_back(
        {{"viewId", id}, {"poseId", id}, {"intrinsicId", "9"}, {"path", scene.views[v].name}});
    root["poses"].push_back({{"poseId", id}, {"pose", Pose(scene.views[v].camera)}});
  }
  for (const ScenePoint& point : scene.points) {
    json observations;
    for (size_t v = 0; v < scene.views.size(); ++v) {
      const Camera& camera = scene.views[v].camera;
      const Eigen::Vector3d seen = camera.rotation * point.position + camera.translation;
      const cv::Point2d at = ByOpenCv(lens, {seen.x(), seen.y(), seen.z()});
      observations.push_back({{"observationId", std::to_string(v)},
                              {"x", {Digits(300 * at.x + 159.5), Digits(300 * at.y + 119.5)}}});
    }
    const Eigen::Vector3d& x = point.position;
    root["structure"].push_back({{"X", {x.x(), x.y(), x.z()}}, {"observations", observations}});
  }
  WriteBytes(folder.path() / "cameras.sfm", root.dump());
  const Scene read = LoadScene({folder.path(), {}, {}});
  ASSERT_EQ(read.points.size(), 40U);
  EXPECT_EQ(read.tracks.Count(), 120U);
  EXPECT_LT(WorstError(read), 1e-6);
}

TEST_F(Meshroom, WhatIsWrongIsNamed) {
  const json good = Given(2, 6);
  json root = good;
  root["intrinsics"][1]["type"] = "fisheye4";
  EXPECT_THAT(ErrorOf(root),
              HasSubstr("view1.png: intrinsics of type 'fisheye4' are not supported"));
  root = good;
  root["intrinsics"][1]["distortionType"] = "radialk3pt";
  EXPECT_THAT(ErrorOf(root),
              HasSubstr("intrinsics of type 'pinhole radialk3pt' are not supported"));
  root = good;
  root["views"][0]["rigId"] = "1";
  EXPECT_THAT(ErrorOf(root), HasSubstr("view0.png: rigs are not supported"));
  root = good;
  root["intrinsics"][0]["focalLength"] = "8,5";
  EXPECT_THAT(ErrorOf(root), HasSubstr("is not as Meshroom writes it: '8,5' is not a number"));
  root = good;
  root["poses"] = json::array();
  EXPECT_THAT(ErrorOf(root), HasSubstr("3 views, none has a pose"));
  root = good;
  root["poses"][1]["pose"]["transform"]["rotation"][0] = "3";
  EXPECT_THAT(ErrorOf(root), HasSubstr("view1.png: rotation: "));
  root = good;
  root["views"][0].erase("path");
  EXPECT_THAT(ErrorOf(root), HasSubstr("is not as Meshroom writes it"));
}

}  // namespace
}  // namespace burin
