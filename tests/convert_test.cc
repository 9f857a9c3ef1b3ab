// burin convert as a process: it writes the right files, and loses nobody's.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "core/scene/formats/openmvs.h"
#include "core/scene/formats/scene_loader.h"
#include "tests/colmap_testing.h"
#include "tests/program_test.h"

namespace burin {
namespace {

namespace fs = std::filesystem;

class Convert : public ProgramTest {
 protected:
  // Every file below the test's folder, but for what the program said.
  std::map<std::string, std::string> Files() const {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder_)) {
      const std::string name = fs::relative(entry.path(), folder_);
      if (entry.is_regular_file() && name != "stdout.txt" && name != "stderr.txt") {
        files[name] = ReadFileBytes(entry.path());
      }
    }
    return files;
  }
  void ExpectRefusedWithoutATrace(const std::vector<std::string>& arguments,
                                  const std::vector<std::string>& parts) {
    const auto before = Files();
    ExpectRefused(arguments, parts);
    EXPECT_EQ(Files(), before);
  }
};

TEST_F(Convert, ThereAndBackIsTheSameScene) {
  WriteColmapScene(TinyScene(), In("a"), true);
  ASSERT_EQ(Run({"convert", In("a"), In("b/scene.mvs")}).exit_code, 0);
  ASSERT_EQ(Run({"convert", In("b/scene.mvs"), In("c"), "--text"}).exit_code, 0);
  ASSERT_EQ(Run({"convert", In("c"), In("d/scene.mvs")}).exit_code, 0);
  const Scene first = LoadScene({In("a"), {}, {}});
  const Scene last = LoadScene({In("d/scene.mvs"), {}, {}});
  ASSERT_EQ(last.views.size(), first.views.size());
  for (size_t v = 0; v < first.views.size(); ++v) {
    EXPECT_LT(
        (last.views[v].camera.ProjectionMatrix() - first.views[v].camera.ProjectionMatrix()).norm(),
        1e-12);
    // The photographs' own bytes.
    EXPECT_EQ(ReadFileBytes(last.views[v].image_path), ReadFileBytes(first.views[v].image_path));
  }
  // Photographs that are in place stay there, unless they would have to be undistorted.
  ASSERT_EQ(Run({"convert", In("d/scene.mvs"), In("d/again.mvs")}).exit_code, 0);
  EXPECT_EQ(ReadFileBytes(In("d/again.mvs")), ReadFileBytes(In("d/scene.mvs")));
  const std::string photograph = first.views[0].name;
  const std::string before = ReadFileBytes(In("d/images/" + photograph));
  Write("d/images/lens.nvm", "NVM_V3\n2\n" + photograph + " 5 1 0 0 0 0 0 0 0.1 0\n" +
                                 first.views[1].name + " 5 1 0 0 0 1 0 0 0.1 0\n0\n");
  ExpectRefused({"convert", In("d/images/lens.nvm"), In("d/third.mvs")},
                {photograph, "would be replaced by its undistorted version"});
  EXPECT_EQ(ReadFileBytes(In("d/images/" + photograph)), before);
  ExpectRefused({"convert", In("a"), In("a")}, {"is the scene itself"});
  ExpectRefused({"convert", In("a"), In("x.nvm")}, {"x.nvm", "neither a folder"});
  ExpectRefused({"convert", In("nothing"), In("x")}, {"nothing: no such file or folder"});
}

TEST_F(Convert, ReplacesNothingUnlessToldTo) {
  WriteColmapScene(TinyScene(), In("a"), false);
  ASSERT_EQ(Run({"convert", In("a"), In("a/scene.mvs")}).exit_code, 0);
  // Back over the model it came from, which has more than an .mvs file keeps.
  ExpectRefusedWithoutATrace({"convert", In("a/scene.mvs"), In("a")},
                             {"a/sparse/cameras.txt: exists already: --overwrite"});
  ExpectRefusedWithoutATrace({"convert", In("a"), In("a/scene.mvs")},
                             {"a/scene.mvs: exists already"});
  // Another photograph of the same name, and another mesh.
  fs::create_directories(In("b/images"));
  Write("b/images/view1.png", "precious");
  ExpectRefusedWithoutATrace({"convert", In("a"), In("b")}, {"b/images/view1.png: exists already"});
  Write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  Write("c/mesh.ply", "");
  fs::create_directories(In("c"));
  Write("c/mesh.ply", "precious");
  ExpectRefusedWithoutATrace({"convert", In("a"), In("c"), "--mesh", In("m.obj")},
                             {"c/mesh.ply: exists already"});
  ASSERT_EQ(Run({"convert", In("a/scene.mvs"), In("a"), "--overwrite"}).exit_code, 0);
  EXPECT_FALSE(fs::exists(In("a/sparse/cameras.txt")));  // else nobody would know which one counts
  EXPECT_EQ(LoadScene({In("a"), {}, {}}).views.size(), 2);
}

TEST_F(Convert, WritesIntoTheFolderOnly) {
  WriteColmapScene(TinyScene(), In("a"), false);
  ExpectRefusedWithoutATrace({"convert", In("a"), ""}, {"output: is empty"});
  ExpectRefusedWithoutATrace({"convert", In("a"), In(".mvs")}, {"has no name before .mvs"});
  // Names that leave their folder, absolute and relative.
  fs::create_directories(In("raw"));
  fs::rename(In("a/images/view0.png"), In("raw/view0.png"));
  fs::rename(In("a/images/view1.png"), In("raw/view1.png"));
  std::string images = ReadFileBytes(In("a/sparse/images.txt"));
  images.replace(images.find("view0.png"), 9, "../../raw/view0.png");
  images.replace(images.find("view1.png"), 9, In("raw/view1.png"));
  WriteBytes(In("a/sparse/images.txt"), images);
  fs::create_directories(In("victim/raw"));
  Write("victim/raw/view0.png", "precious");
  ASSERT_EQ(Run({"convert", In("a"), In("victim/out")}).exit_code, 0);
  EXPECT_EQ(ReadFileBytes(In("victim/raw/view0.png")), "precious");
  const Scene scene = LoadScene({In("victim/out"), {}, {}});
  EXPECT_EQ(cv::norm(scene.views[0].gray, TinyScene().views[0].gray, cv::NORM_INF), 0);
  for (const auto& entry : fs::directory_iterator(In("victim"))) {
    EXPECT_THAT(entry.path().filename().string(), testing::AnyOf("raw", "out"));
  }
}

TEST_F(Convert, KeepsFoldersOfPhotographs) {
  Scene scene = TinyScene();
  scene.views[0].name = "left/0001.png";
  scene.views[1].name = "right/0001.png";
  WriteColmapScene(scene, In("a"), true);
  ASSERT_EQ(Run({"convert", In("a"), In("b/scene.mvs")}).exit_code, 0);
  ASSERT_EQ(Run({"convert", In("b/scene.mvs"), In("c")}).exit_code, 0);
  const Scene last = LoadScene({In("c"), {}, {}});
  EXPECT_EQ(last.views[0].name, "left/0001.png");
  EXPECT_EQ(last.views[1].name, "right/0001.png");
  EXPECT_EQ(LoadScene({In("b/scene.mvs"), In("a/images"), {}}).views[1].name, "right/0001.png");
}

TEST_F(Convert, CarriesMasks) {
  WriteColmapScene(TinyScene(), In("a"), true);
  cv::Mat mask(4, 6, CV_8UC1, cv::Scalar(255));
  mask.at<unsigned char>(1, 2) = 0;
  fs::create_directories(In("masks"));
  cv::imwrite(In("masks/view1.png.png"), mask);
  ASSERT_EQ(Run({"convert", In("a"), In("b/scene.mvs"), "--masks", In("masks")}).exit_code, 0);
  ASSERT_EQ(Run({"convert", In("b/scene.mvs"), In("b/again.mvs")}).exit_code, 0);
  ASSERT_EQ(Run({"convert", In("b/again.mvs"), In("c")}).exit_code, 0);
  for (const SceneSource& source :
       {SceneSource{In("b/scene.mvs"), {}, {}}, SceneSource{In("c"), {}, In("c/masks")}}) {
    const Scene scene = LoadScene(source);
    EXPECT_TRUE(scene.views[0].mask.empty());
    EXPECT_EQ(cv::norm(scene.views[1].mask, mask, cv::NORM_INF), 0);
  }
}

// Raw converters write 12 bits into 16: as PNG they stay what they are, as JPEG they use its 8 bits.
TEST_F(Convert, KeepsTheLevelsOf16Bits) {
  WriteColmapScene(TinyScene(), In("a"), false);
  cv::Mat deep(4, 6, CV_16UC1);
  for (int k = 0; k < 24; ++k) deep.at<uint16_t>(k / 6, k % 6) = static_cast<uint16_t>(170 * k);
  for (const std::string name : {"view0.png", "view1.png"}) {
    ASSERT_TRUE(cv::imwrite(In("a/images/" + name), deep));
  }
  // A lens that moves nothing visibly, so that photographs are written anew.
  WriteBytes(In("a/lens.nvm"),
             "NVM_V3\n2\nimages/view0.png 500 1 0 0 0 0 0 0 1e-9 0\n"
             "images/view1.png 500 1 0 0 0 1 0 0 1e-9 0\n0\n");
  ASSERT_EQ(Run({"convert", In("a/lens.nvm"), In("b")}).exit_code, 2);  // no camera's focal length
  WriteBytes(In("a/lens.nvm"),
             "NVM_V3\n2\nimages/view0.png 50 1 0 0 0 0 0 0 1e-9 0\n"
             "images/view1.png 50 1 0 0 0 1 0 0 1e-9 0\n0\n");
  ASSERT_EQ(Run({"convert", In("a/lens.nvm"), In("b")}).exit_code, 0);
  const cv::Mat written = cv::imread(In("b/images/images/view0.png"), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(written.depth(), CV_16U);
  cv::Mat gray;
  cv::extractChannel(written, gray, 0);
  EXPECT_LE(cv::norm(gray, deep, cv::NORM_INF), 1);
}

TEST_F(Convert, ChecksBeforeItWrites) {
  WriteColmapScene(TinyScene(), In("a"), false);
  fs::rename(In("a/images/view1.png"), In("a/images/view1.tif"));
  WriteBytes(In("a/lens.nvm"),
             "NVM_V3\n2\nimages/view0.png 5 1 0 0 0 0 0 0 0.1 0\n"
             "images/view1.tif 5 1 0 0 0 1 0 0 0.1 0\n0\n");
  ExpectRefusedWithoutATrace({"convert", In("a/lens.nvm"), In("b")}, {"view1.tif"});
  fs::rename(In("a/images/view1.tif"), In("a/images/view1.png"));
  // A folder may have a dot in its name, but not the name of another kind of file.
  ExpectRefusedWithoutATrace({"convert", In("a"), In("b.ply")}, {"is neither a folder (COLMAP)"});
  EXPECT_EQ(Run({"convert", In("a"), In("scan.v2")}).exit_code, 0);
  EXPECT_TRUE(fs::is_directory(In("scan.v2/images")));
}

}  // namespace
}  // namespace burin
