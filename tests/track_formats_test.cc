// Formats that have measurements give them where they are, through the lens, by each format's own formula.
#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "core/scene/formats/colmap.h"
#include "core/scene/formats/scene_loader.h"
#include "core/support/file_bytes.h"
#include "tests/colmap_testing.h"
#include "tests/measured_scene.h"

namespace burin {
namespace {

std::string Digits(double value) {
  std::ostringstream text;
  text << std::setprecision(17) << value;
  return text.str();
}

// MeasuredScene's photographs, and files that have its points exactly where a lens photographs them.
class TracksOfFormat : public testing::Test {
 protected:
  TracksOfFormat() : scene_(MeasuredScene()) {
    for (const View& view : scene_.views) {
      cv::imwrite((folder_.path() / view.name).string(), view.gray);
    }
  }
  // In normalised coordinates.
  Eigen::Vector2d Seen(int view, const ScenePoint& point) const {
    const Camera& camera = scene_.views[view].camera;
    return (camera.Project(point.position) - Eigen::Vector2d(160, 120)) / 300;
  }
  void ExpectExact(const std::string& file) const {
    const Scene read = LoadScene({folder_.path() / file, {}, {}});
    ASSERT_EQ(read.points.size(), 40U);
    EXPECT_EQ(read.tracks.Count(), 120U);
    EXPECT_LT(WorstError(read), 1e-6);
    EXPECT_EQ(read.tracks.Of(3).first[1].keypoint, 31U);
    EXPECT_FALSE(read.views[0].origin.lens.IsNone());
  }
  void Write(const std::string& name, const std::string& text) const {
    WriteBytes(folder_.path() / name, text);
  }
  // place(normalised, view) as the format has it, for every view of every point.
  std::string Points(const std::function<std::string(const Eigen::Vector2d&)>& place) const {
    std::string text;
    for (size_t p = 0; p < scene_.points.size(); ++p) {
      const Eigen::Vector3d& x = scene_.points[p].position;
      text += Digits(x.x()) + " " + Digits(x.y()) + " " + Digits(x.z()) + "\n1 2 3\n3";
      for (int v = 0; v < 3; ++v) {
        text += " " + std::to_string(v) + " " + std::to_string(10 * p + v) + " " +
                place(Seen(v, scene_.points[p]));
      }
      text += "\n";
    }
    return text;
  }

  Scene scene_;
  TempFolder folder_;
};

TEST_F(TracksOfFormat, Bundler) {
  std::string text = "# Bundle file v0.3\n3 40\n";
  std::string list;
  for (const View& view : scene_.views) {
    list += view.name + "\n";
    const Eigen::DiagonalMatrix<double, 3> turn(1, -1, -1);
    const Eigen::Matrix3d r = turn * view.camera.rotation;
    const Eigen::Vector3d t = turn * view.camera.translation;
    text += "300 -0.2 0.05\n";
    for (int k = 0; k < 3; ++k) {
      text += Digits(r(k, 0)) + " " + Digits(r(k, 1)) + " " + Digits(r(k, 2)) + "\n";
    }
    text += Digits(t.x()) + " " + Digits(t.y()) + " " + Digits(t.z()) + "\n";
  }
  text += Points([](const Eigen::Vector2d& p) {
    const Eigen::Vector2d at =
        300 * p * (1 - 0.2 * p.squaredNorm() + 0.05 * std::pow(p.squaredNorm(), 2));
    return Digits(at.x()) + " " + Digits(-at.y());
  });
  Write("bundle.out", text);
  Write("list.txt", list);
  ExpectExact("bundle.out");
}

// VisualSFM counts from the principal point; COLMAP, in the same format, from the picture's corner.
TEST_F(TracksOfFormat, Nvm) {
  for (const bool from_corner : {false, true}) {
    std::string text = "NVM_V3\n\n3\n";
    for (const View& view : scene_.views) {
      const Eigen::Quaterniond q(view.camera.rotation);
      const Eigen::Vector3d c = view.camera.Center();
      text += view.name + " 300 " + Digits(q.w()) + " " + Digits(q.x()) + " " + Digits(q.y()) +
              " " + Digits(q.z()) + " " + Digits(c.x()) + " " + Digits(c.y()) + " " +
              Digits(c.z()) + " 0.2 0\n";
    }
    std::string points = Points([&](const Eigen::Vector2d& p) {
      // p = p' (1 + .2 p'^2), by fixed-point iteration.
      Eigen::Vector2d at = p;
      for (int k = 0; k < 60; ++k) at = p / (1 + 0.2 * at.squaredNorm());
      at = 300 * at + (from_corner ? Eigen::Vector2d(160, 120) : Eigen::Vector2d(0, 0));
      return Digits(at.x()) + " " + Digits(at.y());
    });
    // A point is a line.
    for (size_t at = points.find("\n1 2 3\n"); at != std::string::npos;
         at = points.find("\n1 2 3\n", at)) {
      points.replace(at, 7, " 1 2 3 ");
    }
    Write("s.nvm", text + "\n40\n" + points);
    ExpectExact("s.nvm");
  }
}

TEST_F(TracksOfFormat, OpenMvg) {
  const Lens lens{{-0.2, 0.05, 0, 0, 0.01}};
  nlohmann::json root = {{"sfm_data_version", "0.3"}, {"root_path", ""}};
  root["intrinsics"].push_back(
      {{"key", 4},
       {"value",
        {{"polymorphic_id", 2147483649U},
         {"polymorphic_name", "pinhole_radial_k3"},
         {"ptr_wrapper",
          {{"data",
            {{"width", 320},
             {"height", 240},
             {"focal_length", 300},
             {"principal_point", {159.5, 119.5}},
             {"disto_k3", {lens.brown[0], lens.brown[1], lens.brown[4]}}}}}}}}});
  for (int v = 0; v < 3; ++v) {
    const Camera& c = scene_.views[v].camera;
    root["views"].push_back(
        {{"key", 5 + v},
         {"value",
          {{"ptr_wrapper",
            {{"data",
              {{"filename", scene_.views[v].name}, {"id_intrinsic", 4}, {"id_pose", v}}}}}}}});
    nlohmann::json rotation;
    for (int r = 0; r < 3; ++r) {
      rotation.push_back({c.rotation(r, 0), c.rotation(r, 1), c.rotation(r, 2)});
    }
    const Eigen::Vector3d center = c.Center();
    root["extrinsics"].push_back(
        {{"key", v},
         {"value", {{"rotation", rotation}, {"center", {center.x(), center.y(), center.z()}}}}});
  }
  for (size_t p = 0; p < scene_.points.size(); ++p) {
    const Eigen::Vector3d& x = scene_.points[p].position;
    nlohmann::json observations;
    for (int v = 0; v < 3; ++v) {
      const Eigen::Vector2d seen = Seen(v, scene_.points[p]);
      const cv::Point2d at = ByOpenCv(lens, {seen.x(), seen.y(), 1});
      observations.push_back(
          {{"key", 5 + v},
           {"value", {{"id_feat", 10 * p + v}, {"x", {300 * at.x + 159.5, 300 * at.y + 119.5}}}}});
    }
    root["structure"].push_back(
        {{"key", 70 + p},
         {"value", {{"X", {x.x(), x.y(), x.z()}}, {"observations", observations}}}});
  }
  Write("sfm_data.json", root.dump());
  ExpectExact("sfm_data.json");
  const Scene read = LoadScene({folder_.path() / "sfm_data.json", {}, {}});
  EXPECT_EQ(read.points[2].id, 72U);
  EXPECT_EQ(read.views[0].name, "a.png");
  EXPECT_EQ(read.views[0].origin.image_id, 7U);
  EXPECT_EQ(read.views[0].origin.camera_id, 4U);
  EXPECT_EQ(read.views[0].origin.camera_model, "pinhole_radial_k3");
  // Older files have no places.
  root["structure"][0]["value"]["observations"][0]["value"].erase("x");
  Write("sfm_data.json", root.dump());
  EXPECT_EQ(LoadScene({folder_.path() / "sfm_data.json", {}, {}}).tracks.Count(), 119U);
}

TEST_F(TracksOfFormat, ColmapWithALens) {
  WriteColmapScene(scene_, folder_.path(), false);
  const Lens lens{{-0.2, 0.05, 0.001, -0.002, 0}};
  WriteBytes(folder_.path() / "sparse/cameras.txt",
             "7 OPENCV 320 240 300 300 160 120 -0.2 0.05 0.001 -0.002\n");
  Scene distorted = scene_;
  distorted.tracks = Tracks();
  for (const ScenePoint& point : scene_.points) {
    distorted.tracks.BeginPoint();
    for (int v = 0; v < 3; ++v) {
      const Eigen::Vector2d seen = Seen(v, point);
      const cv::Point2d at = ByOpenCv(lens, {seen.x(), seen.y(), 1});
      distorted.tracks.Add({{300 * at.x + 160, 300 * at.y + 120}, v});
    }
  }
  const std::string cameras = ReadFileBytes(folder_.path() / "sparse/cameras.txt");
  WriteColmapModel(distorted, folder_.path(), false);
  WriteBytes(folder_.path() / "sparse/cameras.txt", cameras);
  const Scene read = LoadScene({folder_.path(), {}, {}});
  EXPECT_EQ(read.tracks.Count(), 120U);
  EXPECT_LT(WorstError(read), 1e-6);
  EXPECT_EQ(read.views[0].origin.lens.brown, lens.brown);
  // What is written has no lens any more, and is the same.
  WriteColmapScene(read, folder_.path() / "b", true);
  const Scene again = LoadScene({folder_.path() / "b", {}, {}});
  EXPECT_TRUE(again.views[0].origin.lens.IsNone());
  EXPECT_EQ(Lines(again, 7), Lines(read, 7));
}

// OpenMVG's numbers begin at 0, which COLMAP's may not.
TEST_F(TracksOfFormat, CamerasThatWereSharedStillAre) {
  Scene scene = MeasuredScene();
  const auto written = [&] {
    WriteColmapModel(scene, folder_.path(), false);
    SceneSource source;
    source.path = folder_.path();
    std::vector<std::uint64_t> ids;
    for (const View& view : scene.views) {
      for (const PosedImage& image : ReadScene(source).images) {
        if (image.name == view.name) ids.push_back(image.camera_id);
      }
    }
    return ids;
  };
  using Ids = std::vector<std::uint64_t>;
  EXPECT_EQ(written(), (Ids{7, 7, 7}));
  for (View& view : scene.views) view.origin.camera_id = 0;
  EXPECT_EQ(written(), (Ids{1, 1, 1}));
  scene.views[0].origin.camera_id = std::uint64_t{1} << 40U;
  EXPECT_EQ(written(), (Ids{1, 2, 2}));
  scene.views[2].camera.fx += 1;
  EXPECT_EQ(written(), (Ids{1, 2, 3}));
  for (View& view : scene.views) view.origin.camera_id = kNoId;
  EXPECT_EQ(written(), (Ids{1, 2, 3}));
}

}  // namespace
}  // namespace burin
