// What people really bring of the formats that burin reads: files left out, photographs scaled, names spelled by another
// system, dialects of other versions. Each is read right, and what was done about it is in Scene::notes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/scene/doubts.h"
#include "core/scene/formats/colmap.h"
#include "core/scene/formats/scene_loader.h"
#include "tests/colmap_testing.h"

namespace burin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr char kCameras[] = "1 PINHOLE 64 48 60 60 32 24\n";

// A COLMAP text model of views a.png, b.png and c.png, 64 x 48, which see one point each way.
class Dialects : public testing::Test {
 protected:
  Dialects() {
    for (const char* name : {"a.png", "b.png", "c.png"}) WritePhotograph(name, 64, 48);
    Write("sparse/cameras.txt", kCameras);
    Write("sparse/images.txt",
          "1 1 0 0 0 0 0 9 1 a.png\n32 24 1\n2 1 0 0 0 1 0 9 1 b.png\n32 24 1\n"
          "3 1 0 0 0 2 0 9 1 c.png\n32 24 1\n");
    Write("sparse/points3D.txt", "1 0 0 0 9 9 9 0 1 0 2 0 3 0\n2 1 0 0 9 9 9 0 1 0 2 0\n");
  }
  void Write(const std::string& name, const std::string& text) const { WriteBytes(In(name), text); }
  void WritePhotograph(const std::string& name, int width, int height) const {
    cv::Mat photograph(height, width, CV_8UC1);
    cv::randu(photograph, 0, 255);
    fs::create_directories(In("images/" + name).parent_path());
    ASSERT_TRUE(cv::imwrite(In("images/" + name).string(), photograph));
  }
  fs::path In(const std::string& name) const { return folder_.path() / name; }
  Scene Load() const { return LoadScene({folder_.path(), {}, {}}); }
  static std::string ErrorOf(const SceneSource& source) {
    try {
      LoadScene(source);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  TempFolder folder_;
};

TEST_F(Dialects, ColmapWithoutPoints) {
  fs::remove(In("sparse/points3D.txt"));
  const Scene scene = Load();
  EXPECT_EQ(scene.views.size(), 3U);
  EXPECT_THAT(scene.points, IsEmpty());
  EXPECT_THAT(DoubtsAbout(scene), Contains(HasSubstr("the scene has no sparse points")));
}

TEST_F(Dialects, ImageTakenOutOfColmap) {
  Write("sparse/images.txt",
        "1 1 0 0 0 0 0 9 1 a.png\n32 24 1\n2 1 0 0 0 1 0 9 1 b.png\n32 24 1\n");
  fs::remove(In("images/c.png"));
  const Scene scene = Load();
  ASSERT_EQ(scene.points.size(), 2U);
  EXPECT_EQ(scene.points[0].views, (std::vector<int>{0, 1}));
  EXPECT_THAT(scene.notes, Contains(AllOf(HasSubstr("1 views of sparse points left out"),
                                          HasSubstr("IMAGE_ID = 3 of point 1"))));
}

TEST_F(Dialects, ABadPointIsLeftOut) {
  Write("sparse/points3D.txt", "1 0 nan 0 9 9 9 0 1 0 2 0\n2 1 0 0 9 9 9 0 1 0 2 0\n");
  const Scene scene = Load();
  ASSERT_EQ(scene.points.size(), 1U);
  EXPECT_EQ(scene.points[0].id, 2U);
  EXPECT_THAT(scene.notes, Contains(HasSubstr("1 sparse points left out")));
}

TEST_F(Dialects, ViewsAreLeftOutByName) {
  fs::remove(In("images/b.png"));
  EXPECT_THAT(ErrorOf({folder_.path(), {}, {}}), HasSubstr("--skip-views 'b.png'"));
  SceneSource source{folder_.path(), {}, {}};
  source.filter.skip = "b.*";
  const Scene scene = LoadScene(source);
  ASSERT_EQ(scene.views.size(), 2U);
  EXPECT_EQ(scene.views[1].name, "c.png");
  ASSERT_EQ(scene.points.size(), 1U);  // the other one is seen by a.png alone
  EXPECT_EQ(scene.points[0].views, (std::vector<int>{0, 1}));
  EXPECT_EQ(scene.tracks.Of(0).size(), 2U);
  EXPECT_THAT(
      scene.notes,
      Contains(HasSubstr("1 of 3 views left out by --views and --skip-views; the first is b.png")));
  source.filter = {"?.png, a*", "b.png"};
  EXPECT_EQ(LoadScene(source).views.size(), 2U);
  source.filter = {"left*", ""};
  EXPECT_THAT(ErrorOf(source), HasSubstr("--views 'left*': no view has such a name"));
}

TEST_F(Dialects, PhotographsScaledByOneFactor) {
  Write("sparse/cameras.txt", "1 PINHOLE 128 96 120 118 64 47\n");
  const Scene scene = Load();
  for (const View& view : scene.views) {
    EXPECT_EQ(view.camera.width, 64);
    EXPECT_EQ(view.camera.height, 48);
    EXPECT_NEAR(view.camera.fx, 60, 1e-8);
    EXPECT_NEAR(view.camera.fy, 59, 1e-8);
    EXPECT_NEAR(view.camera.cx, 32, 1e-8);
    EXPECT_NEAR(view.camera.cy, 23.5, 1e-8);
  }
  EXPECT_EQ(scene.tracks.Of(0).begin()->image_point, Eigen::Vector2d(16, 12));
  EXPECT_THAT(scene.notes,
              Contains(AllOf(HasSubstr("a.png: photograph of 64 x 48 for camera 1 of 128 x 96"),
                             HasSubstr("3 views like it"))));
  Write("sparse/cameras.txt", "1 PINHOLE 128 90 120 118 64 47\n");  // cropped too
  EXPECT_THAT(ErrorOf({folder_.path(), {}, {}}), HasSubstr("a.png: image size: is 64 x 48"));
}

TEST_F(Dialects, TwoViewsOfOnePhotograph) {
  // Folders of a rig, flattened: one of the two photographs is gone.
  Write("s.nvm",
        "NVM_V3\n3\nleft/a.png 60 1 0 0 0 0 0 0 0 0\nright/a.png 60 1 0 0 0 1 0 0 0 0\n"
        "left/b.png 60 1 0 0 0 2 0 0 0 0\n0\n");
  EXPECT_THAT(ErrorOf({In("s.nvm"), In("images"), {}}),
              AllOf(HasSubstr("image right/a.png"), HasSubstr("images/a.png"),
                    HasSubstr("that of image left/a.png too")));
}

// The same letter as one character (NFC) or as two (NFD), and in Latin-1; extensions in capitals.
TEST_F(Dialects, NamesAsOtherSystemsSpellThem) {
  const std::string composed = "caf\xC3\xA9.png";
  for (const std::string& name : {std::string("cafe\xCC\x81.png"), std::string("caf\xE9.png"),
                                  std::string("CAF\xC3\x89.PNG")}) {
    fs::rename(In("images/c.png"), In("images/" + name));
    Write("sparse/images.txt",
          "1 1 0 0 0 0 0 9 1 a.png\n\n2 1 0 0 0 1 0 9 1 b.png\n\n3 1 0 0 0 2 0 9 1 " + composed +
              "\n\n");
    const Scene scene = Load();
    ASSERT_EQ(scene.views.size(), 3U);
    EXPECT_EQ(scene.views[2].name, composed);
    EXPECT_EQ(scene.views[2].image_path.filename(), name);
    fs::rename(In("images/" + name), In("images/c.png"));
  }
}

TEST_F(Dialects, ListsBesideBundlersFiles) {
  const std::string bundle =
      "# Bundle file v0.3\n2 0\n60 0 0\n1 0 0\n0 1 0\n0 0 1\n0 0 0\n60 0 0\n1 0 0\n0 1 0\n0 0 1\n1 "
      "0 0\n";
  Write("images/list.txt", "x.png\ny.png\n");  // of something else
  Write("images/s.bundle.out", bundle);
  Write("images/s.list.txt", "a.png\nb.png\n");
  Write("images/bundle.rd.out", bundle);
  Write("images/bundle.rd.out.list.txt", "b.png\nc.png\n");
  EXPECT_EQ(LoadScene({In("images/s.bundle.out"), {}, {}}).views[0].name, "a.png");
  EXPECT_EQ(LoadScene({In("images/bundle.rd.out"), {}, {}}).views[0].name, "b.png");
  fs::remove(In("images/list.txt"));
  fs::remove(In("images/s.list.txt"));
  EXPECT_THAT(ErrorOf({In("images/s.bundle.out"), {}, {}}),
              AllOf(HasSubstr("s.bundle.out.list.txt, "), HasSubstr("images/s.list.txt, ")));
}

nlohmann::json OpenMvgView(const std::string& name, int key) {
  return {
      {"key", key},
      {"value",
       {{"ptr_wrapper",
         {{"data",
           {{"local_path", ""}, {"filename", name}, {"id_intrinsic", 0}, {"id_pose", key}}}}}}}};
}

TEST_F(Dialects, OpenMvgBefore2) {
  nlohmann::json root = {{"sfm_data_version", "0.3"}, {"root_path", "images"}};
  root["views"] = {OpenMvgView("a.png", 0), OpenMvgView("b.png", 1), OpenMvgView("c.png", 2)};
  root["intrinsics"] = {{{"key", 0},
                         {"value",
                          {{"polymorphic_id", 2147483649U},
                           {"polymorphic_name", "pinhole_brown_t2"},
                           {"ptr_wrapper",
                            {{"data",
                              {{"value0",
                                {{"width", 64},
                                 {"height", 48},
                                 {"focal_length", 60},
                                 {"principal_point", {31.5, 23.5}}}},
                               {"disto_t2", {0.01, 0, 0, 0.001, 0}}}}}}}}}};
  root["extrinsics"] = nlohmann::json::array();
  Write("sfm_data.json", root.dump());
  EXPECT_THAT(ErrorOf({In("sfm_data.json"), {}, {}}),
              HasSubstr("3 views, none has a pose: this is the listing"));
  for (const int key : {0, 2}) {
    root["extrinsics"].push_back(
        {{"key", key},
         {"value", {{"rotation", {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, {"center", {key, 0, 0}}}}});
  }
  Write("sfm_data.json", root.dump());
  const PosedScene scene = ReadScene({In("sfm_data.json"), {}, {}});
  ASSERT_EQ(scene.images.size(), 2U);
  EXPECT_EQ(scene.images[0].camera.fx, 60);
  EXPECT_EQ(scene.images[0].camera.cx, 32);
  EXPECT_EQ(scene.images[0].camera.cy, 24);
  EXPECT_EQ(scene.images[0].lens.brown, (std::array<double, 5>{0.01, 0, 0.001, 0, 0}));
  EXPECT_THAT(scene.notes, Contains(AllOf(HasSubstr("1 of 3 views left out: they have no pose"),
                                          HasSubstr("the first is b.png"))));
}

}  // namespace
}  // namespace burin
