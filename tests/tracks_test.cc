// What structure from motion measured stays with a scene: from every format that has it, through lenses, without
// views, and back into files.
#include "core/scene/tracks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "core/scene/formats/openmvs.h"
#include "core/scene/formats/scene_loader.h"
#include "core/scene/lens_points.h"
#include "core/support/file_bytes.h"
#include "core/synthetic/synthetic.h"
#include "tests/colmap_testing.h"

namespace burin {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;

// Three views in a row of 320x240 pixels, 40 points before them that all see, each measured off its
// projection by its own part of a pixel.
Scene MeasuredScene() {
  Scene scene;
  for (int v = 0; v < 3; ++v) {
    View& view = scene.views.emplace_back();
    view.name = std::string(1, static_cast<char>('c' - v)) + ".png";
    view.camera.width = 320;
    view.camera.height = 240;
    view.camera.fx = view.camera.fy = 300;
    view.camera.cx = 160;
    view.camera.cy = 120;
    view.camera.rotation =
        Eigen::AngleAxisd(0.1 * (v - 1), Eigen::Vector3d(0.1, 1, 0).normalized()).matrix();
    view.camera.translation = {0.5 * (v - 1), 0.02 * v, 4};
    view.gray = cv::Mat(240, 320, CV_8UC1, cv::Scalar(50 * v));
    view.origin.image_id = 30 - 10 * v;
    view.origin.camera_id = 7;
  }
  for (int p = 0; p < 40; ++p) {
    ScenePoint& point = scene.points.emplace_back();
    point.position = {0.25 * (p % 8) - 0.9, 0.4 * (p / 8) - 0.8, 0.1 * (p % 5)};
    point.views = {0, 1, 2};
    point.id = 100 - p;
    scene.tracks.BeginPoint();
    for (int v = 0; v < 3; ++v) {
      const Eigen::Vector2d off(0.01 * p, -0.02 * p + 0.3 * v);
      scene.tracks.Add({scene.views[v].camera.Project(point.position) + off, v});
    }
  }
  return scene;
}

// One line a measurement: point id, view's name and place, sorted.
std::vector<std::string> Lines(const Scene& scene, int digits) {
  std::vector<std::string> lines;
  for (size_t p = 0; p < scene.points.size(); ++p) {
    for (const Measurement& measured : scene.tracks.Of(p)) {
      std::ostringstream line;
      line << scene.points[p].id << " " << scene.views[measured.view].name << std::fixed
           << std::setprecision(digits) << " " << measured.image_point.transpose();
      lines.push_back(line.str());
    }
  }
  std::sort(lines.begin(), lines.end());
  return lines;
}

double WorstError(const Scene& scene) {
  double worst = 0;
  for (size_t p = 0; p < scene.points.size(); ++p) {
    for (const Measurement& measured : scene.tracks.Of(p)) {
      const Camera& camera = scene.views[measured.view].camera;
      worst =
          std::max(worst, (camera.Project(scene.points[p].position) - measured.image_point).norm());
    }
  }
  return worst;
}

TEST(Tracks, ComeBackFromTextAndBinary) {
  const TempFolder folder;
  const Scene scene = MeasuredScene();
  WriteColmapScene(scene, folder.path() / "a", /*binary=*/false);
  const Scene first = LoadScene({folder.path() / "a", {}, {}});
  EXPECT_EQ(first.tracks.Count(), 120U);
  EXPECT_EQ(first.tracks.PointCount(), 40U);
  EXPECT_EQ(Lines(first, 6), Lines(scene, 6));
  EXPECT_GT(WorstError(first), 0.8);  // they are no projections
  for (const bool binary : {false, true}) {
    WriteColmapScene(first, folder.path() / "b", binary);
    const Scene again = LoadScene({folder.path() / "b", {}, {}});
    EXPECT_EQ(again.tracks.Count(), first.tracks.Count());
    EXPECT_EQ(Lines(again, 9), Lines(first, 9));
    // Views are in order of their names now, and keep their numbers.
    ASSERT_EQ(again.views[0].name, "a.png");
    EXPECT_EQ(again.views[0].origin.image_id, 10U);
    EXPECT_EQ(again.views[2].origin.image_id, 30U);
    for (const View& view : again.views) {
      EXPECT_EQ(view.origin.camera_id, 7U);
      EXPECT_EQ(view.origin.camera_model, "PINHOLE");
    }
  }
  // A format without places keeps who sees what, and the numbers of the images.
  WriteOpenMvs(first, folder.path() / "a/scene.mvs");
  const Scene other = LoadScene({folder.path() / "a/scene.mvs", {}, {}});
  EXPECT_TRUE(other.tracks.IsEmpty());
  EXPECT_EQ(other.points.size(), 40U);
  EXPECT_THAT(other.points[0].views, ElementsAre(0, 1, 2));
  EXPECT_EQ(other.views[0].origin.image_id, 10U);
}

TEST(Tracks, SharedCamerasThatDifferAreWrittenApart) {
  const TempFolder folder;
  Scene scene = MeasuredScene();
  scene.views[1].camera.fx = 301;
  scene.views[2].origin.image_id = scene.views[0].origin.image_id;
  WriteColmapScene(scene, folder.path(), true);
  const Scene read = LoadScene({folder.path(), {}, {}});
  EXPECT_EQ(read.views[1].camera.fx, 301);
  EXPECT_EQ(read.views[2].camera.fx, 300);
  EXPECT_NE(read.views[0].origin.image_id, read.views[2].origin.image_id);
}

TEST(Tracks, WithoutMeasurementsProjectionsAreWritten) {
  const TempFolder folder;
  Scene scene = MeasuredScene();
  scene.tracks = Tracks();
  WriteColmapScene(scene, folder.path(), true);
  const Scene read = LoadScene({folder.path(), {}, {}});
  EXPECT_EQ(read.tracks.Count(), 120U);
  EXPECT_LT(WorstError(read), 1e-8);
}

// What the images do not confirm is no measurement; the point keeps its view.
TEST(Tracks, OnlyObservationsOfTheSamePointCount) {
  const TempFolder folder;
  WriteColmapScene(MeasuredScene(), folder.path(), false);
  WriteBytes(folder.path() / "sparse/images.txt",
             "1 1 0 0 0 0 0 4 7 a.png\n"
             "10 20 -1 11 21 5 12 22 6\n"
             "2 1 0 0 0 1 0 4 7 b.png\n"
             "\n"
             "3 1 0 0 0 2 0 4 7 c.png\n"
             "13 23 5\n");
  WriteBytes(folder.path() / "sparse/points3D.txt",
             "5 0 0 0 0 0 0 0 1 1 2 0 3 0\n"  // all but image 2, which has none
             "6 0 0 0 0 0 0 0 1 1 3 7\n");    // of another point; beyond the end
  const Scene scene = LoadScene({folder.path(), {}, {}});
  ASSERT_EQ(scene.points.size(), 2U);
  EXPECT_THAT(scene.points[0].views, ElementsAre(0, 1, 2));
  EXPECT_THAT(scene.points[1].views, ElementsAre(0, 2));
  EXPECT_EQ(scene.points[1].id, 6U);
  ASSERT_EQ(scene.tracks.Of(0).size(), 2U);
  EXPECT_EQ(scene.tracks.Of(0).first[0].image_point, Eigen::Vector2d(11, 21));
  EXPECT_EQ(scene.tracks.Of(0).first[0].keypoint, 1U);
  EXPECT_EQ(scene.tracks.Of(0).first[1].view, 2);
  EXPECT_EQ(scene.tracks.Of(1).size(), 0U);
  EXPECT_EQ(scene.tracks.Of(2).size(), 0U);  // no such point
}

TEST(Tracks, WithoutViews) {
  Scene scene = MeasuredScene();
  const Scene without = WithoutViews(scene, {0, -1, 1});
  ASSERT_EQ(without.views.size(), 2U);
  EXPECT_EQ(without.views[1].name, scene.views[2].name);
  EXPECT_EQ(without.tracks.Count(), 80U);
  EXPECT_NEAR(WorstError(without), WorstError(scene), 1e-12);
  for (size_t p = 0; p < without.points.size(); ++p) {
    EXPECT_THAT(without.points[p].views, ElementsAre(0, 1));
    EXPECT_EQ(without.points[p].id, scene.points[p].id);
    ASSERT_EQ(without.tracks.Of(p).size(), 2U);
    EXPECT_EQ(without.tracks.Of(p).first[1].image_point, scene.tracks.Of(p).first[2].image_point);
  }
}

TEST(Tracks, SyntheticPhotographsShowThePointsWhereTheyAreMeasured) {
  SyntheticOptions options;
  options.width = 160;
  options.height = 120;
  options.samples_per_axis = 1;
  options.point_count = 200;
  options.truth_point_count = 100;
  options.point_noise_px = 0;
  const Scene exact = MakeSyntheticScene(options).scene;
  ASSERT_EQ(exact.tracks.PointCount(), exact.points.size());
  for (size_t p = 0; p < exact.points.size(); ++p) {
    std::vector<int> views;
    for (const Measurement& measured : exact.tracks.Of(p)) views.push_back(measured.view);
    EXPECT_EQ(views, exact.points[p].views);
  }
  EXPECT_LT(WorstError(exact), 1e-9);
  // Points and cameras that are wrong do not reproject.
  options.point_noise_px = 0.3;
  EXPECT_GT(WorstError(MakeSyntheticScene(options).scene), 0.5);
  options.point_noise_px = 0;
  options.pose_noise_px = 4;
  EXPECT_GT(WorstError(MakeSyntheticScene(options).scene), 4);
}

// A lens, and where it photographs a point of the camera frame at unit depth, by another program's formula.
cv::Point2d ByOpenCv(const Lens& lens, const cv::Point3d& point) {
  std::vector<cv::Point2d> photographed;
  cv::projectPoints(std::vector<cv::Point3d>{point}, cv::Vec3d(), cv::Vec3d(), cv::Matx33d::eye(),
                    cv::Vec<double, 5>(lens.brown.data()), photographed);
  return photographed[0];
}

TEST(Tracks, LensesAreTakenOut) {
  Camera camera = MeasuredScene().views[0].camera;
  Lens lens;
  for (const std::array<double, 5>& brown :
       {std::array<double, 5>{-0.3, 0.12, 0.002, -0.003, -0.01},
        std::array<double, 5>{0.2, -0.05, -0.001, 0.004, 0}}) {
    lens.brown = brown;
    const PointUndistortion undistortion(camera, lens);
    for (double x = 0; x <= 320; x += 40) {
      for (double y = 0; y <= 240; y += 40) {
        const cv::Point2d at =
            ByOpenCv(lens, {(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1});
        const auto back =
            undistortion({at.x * camera.fx + camera.cx, at.y * camera.fy + camera.cy});
        ASSERT_TRUE(back.has_value()) << x << " " << y;
        EXPECT_LT((*back - Eigen::Vector2d(x, y)).norm(), 1e-7);
      }
    }
  }
  // r (1 - 0.9 r^2) grows up to r = .609, where it is .406: nothing is photographed farther out.
  lens.brown = {-0.9, 0, 0, 0, 0};
  const PointUndistortion folding(camera, lens);
  EXPECT_TRUE(folding({160 + 300 * 0.40, 120}).has_value());
  EXPECT_FALSE(folding({160 + 300 * 0.41, 120}).has_value());
  EXPECT_FALSE(folding({std::numeric_limits<double>::quiet_NaN(), 120}).has_value());
  lens.brown = {};
  lens.measured = -0.9;  // that of the photograph, in closed form
  const PointUndistortion measured(camera, lens);
  EXPECT_NEAR(measured({160 + 300 * 0.5, 120})->x(), 160 + 300 * 0.5 * (1 - 0.9 * 0.25), 1e-9);
  EXPECT_FALSE(measured({160 + 300 * 0.62, 120}).has_value());
}

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

}  // namespace
}  // namespace burin
