// reconstruction.json gives the cameras, points and measurements that it was made of, by OpenSfM's own formulas.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "tests/given_scene.h"
#include "tests/measured_scene.h"

namespace burin {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

json Numbers(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

json Shot(const Camera& camera, const std::string& model) {
  const Eigen::AngleAxisd turn(camera.rotation);
  return {{"rotation", Numbers(turn.angle() * turn.axis())},
          {"translation", Numbers(camera.translation)},
          {"camera", model},
          {"orientation", 6}};
}

class OpenSfm : public GivenScene {
 protected:
  // The cameras of a picture twice as large.
  json Given() const {
    json largest;
    for (int v = 0; v < 2; ++v) {
      const Camera& c = CameraAt(v);
      const std::string model = "v2 maker " + std::to_string(v) + " brown 0.85";
      largest["cameras"][model] = {
          {"projection_type", "brown"}, {"width", 12},         {"height", 8},
          {"focal_x", c.fx / 6},        {"focal_y", c.fy / 6}, {"c_x", (c.cx - 3) / 6},
          {"c_y", (c.cy - 2) / 6},      {"k1", 0.0},           {"k2", 0.0}};
      largest["shots"][scene_.views[v].name] = Shot(c, model);
    }
    json smaller = largest;
    smaller["shots"].erase("view0.png");
    for (size_t p = 0; p < scene_.points.size(); ++p) {
      largest["points"][std::to_string(10 + p)] = {
          {"color", {1, 2, 3}}, {"coordinates", Numbers(scene_.points[p].position)}};
    }
    return {smaller, largest};
  }
  std::string ErrorOf(const json& root) const {
    WriteFile("reconstruction.json", root.dump());
    return LoadError(Folder());
  }
};

TEST_F(OpenSfm, CamerasAndPoints) {
  WriteFile("reconstruction.json", Given().dump());
  EXPECT_EQ(FormatOf(Folder()), "OpenSfM");
  std::string tracks = "OPENSFM_TRACKS_VERSION_v2\n";
  for (int p = 12; p >= 10; --p) {
    for (int v = 0; v < 2; ++v) {
      tracks += "view" + std::to_string(v) + ".png\t" + std::to_string(p) +
                "\t7\t0.1\t-0.2\t0.001\t1\t2\t3\t-1\t-1\n";
    }
  }
  WriteFile("tracks.csv", tracks + "other.png\t10\t1\t0\t0\t1\t1\t1\t1\t-1\t-1\n");
  const Scene scene = LoadScene({Folder(), {}, {}});
  ExpectScene(scene, true);
  EXPECT_THAT(scene.notes,
              testing::ElementsAre("the largest of 2 reconstructions is read, with 2 shots"));
  ExpectScene(LoadScene({Folder() / "reconstruction.json", Images(), {}}), true);
  const Measurement& measured = *scene.tracks.Of(1).begin();
  EXPECT_NEAR(measured.image_point.x(), 3 + 0.1 * 6, 1e-12);
  EXPECT_NEAR(measured.image_point.y(), 2 - 0.2 * 6, 1e-12);
  EXPECT_EQ(measured.keypoint, 7U);
}

TEST_F(OpenSfm, WithoutTracksPointsAreLeftOutWithALine) {
  fs::create_directories(Folder() / "opensfm");
  WriteFile("opensfm/reconstruction.json", Given()[1].dump());
  const Scene scene = LoadScene({Folder() / "opensfm", {}, {}});  // its photographs are above
  ExpectScene(scene, false);
  EXPECT_THAT(scene.notes, testing::ElementsAre(HasSubstr("tracks.csv is not beside")));
}

// Points are where the file has them, through the lens.
TEST(OpenSfmTracks, AreWhereTheLensPhotographsThePoints) {
  const TempFolder folder;
  const Scene scene = MeasuredScene();
  const Lens lens{{-0.2, 0.05, 0.001, -0.002, 0.01}};
  json root;
  root["cameras"]["one"] = {{"projection_type", "brown"},
                            {"width", 320},
                            {"height", 240},
                            {"focal_x", 300.0 / 320},
                            {"focal_y", 300.0 / 320},
                            {"c_x", 0},
                            {"c_y", 0},
                            {"k1", lens.brown[0]},
                            {"k2", lens.brown[1]},
                            {"p1", lens.brown[2]},
                            {"p2", lens.brown[3]},
                            {"k3", lens.brown[4]}};
  std::ostringstream tracks;
  tracks << std::setprecision(17);
  for (size_t v = 0; v < scene.views.size(); ++v) {
    const View& view = scene.views[v];
    cv::imwrite((folder.path() / view.name).string(), view.gray);
    root["shots"][view.name] = Shot(view.camera, "one");
    for (size_t p = 0; p < scene.points.size(); ++p) {
      const Eigen::Vector3d seen =
          view.camera.rotation * scene.points[p].position + view.camera.translation;
      const cv::Point2d at = ByOpenCv(lens, {seen.x(), seen.y(), seen.z()});
      tracks << view.name << "\t" << p << "\t" << 10 * p + v << "\t" << 300.0 / 320 * at.x << "\t"
             << 300.0 / 320 * at.y << "\t1\t0\t0\t0\n";
    }
  }
  for (size_t p = 0; p < scene.points.size(); ++p) {
    root["points"][std::to_string(p)] = {{"coordinates", Numbers(scene.points[p].position)}};
  }
  WriteBytes(folder.path() / "reconstruction.json", json::array({root}).dump());
  WriteBytes(folder.path() / "tracks.csv", tracks.str());
  const Scene read = LoadScene({folder.path(), {}, {}});
  ASSERT_EQ(read.points.size(), 40U);
  EXPECT_EQ(read.tracks.Count(), 120U);
  EXPECT_LT(WorstError(read), 1e-6);
}

TEST_F(OpenSfm, WhatIsWrongIsNamed) {
  const json good = Given()[1];
  json root = good;
  root["cameras"]["v2 maker 1 brown 0.85"]["projection_type"] = "fisheye";
  EXPECT_THAT(ErrorOf(root),
              HasSubstr("shot view1.png: projection_type 'fisheye' is not supported"));
  root = good;
  root["cameras"]["v2 maker 1 brown 0.85"]["height"] = 12;
  EXPECT_THAT(ErrorOf(root),
              HasSubstr("view1.png: image size: is 6 x 4, not of the shape of its camera "
                        "v2 maker 1 brown 0.85"));
  root = good;
  root["shots"]["view1.png"]["camera"] = "none";
  EXPECT_THAT(ErrorOf(root), HasSubstr("shot view1.png: its camera is missing"));
  root = good;
  root["shots"]["view1.png"].erase("rotation");
  EXPECT_THAT(ErrorOf(root), HasSubstr("is not as OpenSfM writes it"));
  EXPECT_THAT(ErrorOf(json::array()), HasSubstr("is not as OpenSfM writes it"));
  WriteFile("tracks.csv", "view0.png\t10\t7\t0.1\tnone\n");
  EXPECT_THAT(ErrorOf(good), HasSubstr("tracks.csv: line 1: y: 'none' is not a number"));
}

}  // namespace
}  // namespace burin
