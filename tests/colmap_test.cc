#include "core/scene/formats/colmap.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <tuple>

#include "core/scene/formats/colmap_model.h"
#include "core/scene/formats/scene_loader.h"
#include "core/support/parallel.h"
#include "tests/colmap_testing.h"

namespace burin {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;

bool SamePixels(const cv::Mat& a, const cv::Mat& b) {
  return a.type() == b.type() && a.size() == b.size() && cv::norm(a, b, cv::NORM_INF) == 0;
}

// Bit for bit, but for cameras, which are rounded to 12 digits.
void ExpectSameScene(const Scene& a, const Scene& b) {
  ASSERT_EQ(a.views.size(), b.views.size());
  for (std::size_t v = 0; v < a.views.size(); ++v) {
    const Camera& ca = a.views[v].camera;
    const Camera& cb = b.views[v].camera;
    EXPECT_EQ(a.views[v].name, b.views[v].name);
    EXPECT_TRUE(SamePixels(a.views[v].gray, b.views[v].gray));
    EXPECT_EQ(ca.width, cb.width);
    EXPECT_EQ(ca.height, cb.height);
    EXPECT_NEAR(ca.fx, cb.fx, 1e-9);
    EXPECT_NEAR(ca.fy, cb.fy, 1e-9);
    EXPECT_NEAR(ca.cx, cb.cx, 1e-9);
    EXPECT_NEAR(ca.cy, cb.cy, 1e-9);
    EXPECT_LT((ca.translation - cb.translation).cwiseAbs().maxCoeff(), 1e-11);
    EXPECT_LT((ca.rotation - cb.rotation).cwiseAbs().maxCoeff(), 1e-11);
  }
  ASSERT_EQ(a.points.size(), b.points.size());
  for (std::size_t p = 0; p < a.points.size(); ++p) {
    EXPECT_EQ(a.points[p].position, b.points[p].position);
    EXPECT_EQ(a.points[p].views, b.points[p].views);
  }
}

TEST(Colmap, TextAndBinaryRoundTrip) {
  const TempFolder folder;
  const Scene scene = TinyScene();
  WriteColmapScene(scene, folder.path() / "text", false);
  WriteColmapScene(scene, folder.path() / "binary", true);
  ExpectSameScene(LoadScene({folder.path() / "text", {}, {}}), scene);
  ExpectSameScene(LoadScene({folder.path() / "binary", {}, {}}), scene);
  // Both formats carry the same bits, rotations included.
  const Scene text = LoadScene({folder.path() / "text", {}, {}});
  const Scene binary = LoadScene({folder.path() / "binary", {}, {}});
  for (int v = 0; v < 2; ++v) {
    EXPECT_EQ(text.views[v].camera.rotation, binary.views[v].camera.rotation);
  }
}

TEST(Colmap, WritingTwiceGivesTheSameBytesAndRemovesTheOtherFormat) {
  const TempFolder folder;
  const Scene scene = TinyScene();
  for (const bool binary : {false, true}) {
    const std::string extension = binary ? ".bin" : ".txt";
    WriteColmapScene(scene, folder.path() / "a", binary);
    WriteColmapScene(scene, folder.path() / "b", binary);
    int files = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder.path() / "a")) {
      if (!entry.is_regular_file()) continue;
      ++files;
      const fs::path relative = fs::relative(entry.path(), folder.path() / "a");
      EXPECT_EQ(ReadFileBytes(entry.path()), ReadFileBytes(folder.path() / "b" / relative));
      EXPECT_TRUE(relative.extension() == ".png" || relative.extension() == extension) << relative;
    }
    EXPECT_EQ(files, 5);
  }
}

TEST(Colmap, JpegAndFloatViewsInSubfoldersAreWrittenAsEightBits) {
  const TempFolder folder;
  Scene scene = TinyScene();
  scene.views[0].name = "left/a b.jpg";
  scene.views[1].name = "right/a b.PNG";
  scene.views[0].gray.setTo(100);
  scene.views[1].gray = cv::Mat(4, 6, CV_32FC1, cv::Scalar(17.6));
  scene.views[1].gray.at<float>(0, 0) = -3;
  scene.views[1].gray.at<float>(0, 1) = 300;
  WriteColmapScene(scene, folder.path(), false);
  const Scene loaded = LoadScene({folder.path(), {}, {}});
  EXPECT_EQ(loaded.views[0].name, "left/a b.jpg");
  EXPECT_TRUE(SamePixels(loaded.views[0].gray, scene.views[0].gray));
  EXPECT_EQ(loaded.views[1].image_path, folder.path() / "images/right/a b.PNG");
  EXPECT_EQ(loaded.views[1].gray.at<unsigned char>(0, 0), 0);
  EXPECT_EQ(loaded.views[1].gray.at<unsigned char>(0, 1), 255);
  EXPECT_EQ(loaded.views[1].gray.at<unsigned char>(3, 5), 18);
}

// Images out of name order, comments, CRLF, blanks, a shared camera, unnormalised quaternion, a
// point with a repeated image and one seen once; no line for the last image's observations.
TEST(Colmap, HandWrittenTextGivesTheExpectedNumbers) {
  const TempFolder folder;
  const fs::path sparse = folder.path() / "sparse" / "0";
  WriteBytes(sparse / "cameras.txt",
             "# cameras\r\n"
             "7 SIMPLE_PINHOLE 6 4 5.5 3.25 2\r\n"
             "\n"
             "  2\tPINHOLE 5 3 4 4.5 2.5 1e0  \n");
  WriteBytes(sparse / "images.txt",
             "# images\n"
             "9 1 0 0 0 1 2 3 7 c.png\n"
             "1.5 2.5 11 0 0 -1\n"
             "4 0 0 0 2 -1 0 0.5 2 a.png\n"
             "\n"
             "5 1 1 0 0 0 0 0 7 b with spaces.png");
  WriteBytes(sparse / "points3D.txt",
             "30 0.5 1 2 255 0 10 0.7 5 0 9 0 5 1\n"
             "10 -1 1 2 0 0 0 0 9 0 4 0 5 0\n"
             "20 3 1 2 0 0 0 -1 9 0\n");
  for (const char* name : {"a.png", "b with spaces.png", "c.png"}) {
    const bool is_a = name[0] == 'a';
    fs::create_directories(folder.path() / "images");
    ASSERT_TRUE(cv::imwrite((folder.path() / "images" / name).string(),
                            cv::Mat(is_a ? 3 : 4, is_a ? 5 : 6, CV_8UC1, cv::Scalar(name[0]))));
  }

  const Scene scene = LoadScene({folder.path(), {}, {}});
  ASSERT_EQ(scene.views.size(), 3U);
  EXPECT_EQ(scene.views[0].name, "a.png");
  EXPECT_EQ(scene.views[1].name, "b with spaces.png");
  EXPECT_EQ(scene.views[2].name, "c.png");
  for (int v = 0; v < 3; ++v) EXPECT_EQ(scene.views[v].gray.at<unsigned char>(1, 1), 'a' + v);

  const Camera& a = scene.views[0].camera;
  EXPECT_EQ(a.width, 5);
  EXPECT_EQ(a.height, 3);
  EXPECT_EQ(a.fx, 4);
  EXPECT_EQ(a.fy, 4.5);
  EXPECT_EQ(a.cx, 2.5);
  EXPECT_EQ(a.cy, 1);
  // Half a turn around z.
  EXPECT_EQ(a.rotation, Eigen::Matrix3d(Eigen::Vector3d(-1, -1, 1).asDiagonal()));
  EXPECT_EQ(a.translation, Eigen::Vector3d(-1, 0, 0.5));
  const Camera& c = scene.views[2].camera;
  EXPECT_EQ(c.fx, 5.5);
  EXPECT_EQ(c.fy, 5.5);
  EXPECT_EQ(c.cx, 3.25);
  EXPECT_EQ(c.cy, 2);
  EXPECT_EQ(c.rotation, Eigen::Matrix3d(Eigen::Matrix3d::Identity()));
  // A quarter turn around x takes y to z.
  const Eigen::Vector3d turned = scene.views[1].camera.rotation * Eigen::Vector3d::UnitY();
  EXPECT_LT((turned - Eigen::Vector3d::UnitZ()).norm(), 1e-15);

  ASSERT_EQ(scene.points.size(), 2U);
  EXPECT_EQ(scene.points[0].position, Eigen::Vector3d(-1, 1, 2));
  EXPECT_THAT(scene.points[0].views, ElementsAre(0, 1, 2));
  EXPECT_EQ(scene.points[1].position, Eigen::Vector3d(0.5, 1, 2));
  EXPECT_THAT(scene.points[1].views, ElementsAre(1, 2));
}

TEST(Colmap, SixteenBitAndColourImagesBecomeGreyLevels) {
  const TempFolder folder;
  WriteColmapScene(TinyScene(), folder.path(), true);
  cv::imwrite((folder.path() / "images/view0.png").string(),
              cv::Mat(4, 6, CV_16UC1, cv::Scalar(257 * 100 + 128)));
  cv::imwrite((folder.path() / "images/view1.png").string(),
              cv::Mat(4, 6, CV_8UC3, cv::Scalar(90, 90, 90)));
  const Scene scene = LoadScene({folder.path(), {}, {}});
  ASSERT_EQ(scene.views[0].gray.type(), CV_32FC1);
  EXPECT_NEAR(scene.views[0].gray.at<float>(2, 2), 100 + 128 / 257.0, 1e-4);
  ASSERT_EQ(scene.views[1].gray.type(), CV_8UC1);
  EXPECT_EQ(scene.views[1].gray.at<unsigned char>(2, 2), 90);
}

TEST(Colmap, BinaryComesBeforeTextAndSparseBeforeSparse0) {
  const TempFolder folder;
  const fs::path workspace = folder.path() / "workspace";
  WriteColmapScene(TinyScene(), workspace, true);
  fs::remove_all(workspace / "sparse");
  // Each model added takes precedence over those before it.
  const std::tuple<const char*, bool> models[] = {
      {"sparse/0", false}, {"sparse/0", true}, {"sparse", false}, {"sparse", true}};
  double focal_px = 10;
  for (const auto& [place, binary] : models) {
    Scene scene = TinyScene();
    scene.views[0].camera.fx = ++focal_px;
    WriteColmapScene(scene, folder.path() / "other", binary);
    fs::create_directories(workspace / place);
    fs::copy(folder.path() / "other/sparse", workspace / place);
    EXPECT_EQ(LoadScene({workspace, {}, {}}).views[0].camera.fx, focal_px);
  }
}

// The same pixels whatever the number of threads, undistortion included.
TEST(Colmap, AModelIsReadWithoutItsWorkspace) {
  const TempFolder folder;
  WriteColmapScene(TinyScene(), folder.path(), true);
  for (const bool binary : {true, false}) {
    WriteColmapModel(TinyScene(), folder.path(), binary);
    // Its photographs are those of the workspace above.
    const Scene scene = LoadScene({folder.path() / "sparse", {}, {}});
    EXPECT_EQ(scene.points.size(), 3U);
    EXPECT_EQ(scene.views[1].image_path, folder.path() / "images" / "view1.png");
  }
  const std::filesystem::path alone = folder.path() / "a" / "b" / "c";
  std::filesystem::create_directories(alone.parent_path());
  std::filesystem::rename(folder.path() / "sparse", alone);
  EXPECT_EQ(LoadScene({alone, {}, {}}, /*with_images=*/false).views.size(), 2U);
  EXPECT_EQ(LoadScene({alone, folder.path() / "images", {}}).views.size(), 2U);
  EXPECT_THAT(LoadError(alone), testing::HasSubstr("a/b/c/images: folder is missing"));
  std::filesystem::remove(alone / "points3D.txt");
  EXPECT_TRUE(LoadScene({alone, folder.path() / "images", {}}).points.empty());
  std::filesystem::remove(alone / "images.txt");
  EXPECT_THAT(LoadError(alone), testing::HasSubstr("is no scene that burin knows"));
}

TEST(Colmap, ThreadCountDoesNotMatter) {
  const TempFolder folder;
  WriteColmapScene(TinyScene(), folder.path(), false);
  WriteBytes(folder.path() / "sparse/cameras.txt",
             "1 OPENCV 6 4 5 5 3 2 -0.3 0.1 0.02 -0.03\n2 RADIAL 6 4 5 3 2 -0.2 0\n");
  const ThreadScope one_thread(1);
  const Scene one = LoadScene({folder.path(), {}, {}});
  const ThreadScope two_threads(2);
  const Scene two = LoadScene({folder.path(), {}, {}});
  ExpectSameScene(one, two);
}

fs::path RealData(const std::string& name) {
  const char* folder = std::getenv("BURIN_SHARED_DATA");
  return folder == nullptr ? fs::path() : fs::path(folder) / name;
}

// Every point lies in front of the cameras that track it and inside their images, but for the
// reprojection error.
void ExpectPointsInsideTheirImages(const Scene& scene) {
  double worst_px = 0;
  int behind = 0;
  for (const ScenePoint& point : scene.points) {
    EXPECT_TRUE(std::is_sorted(point.views.begin(), point.views.end()));
    EXPECT_GE(point.views.size(), 2U);
    for (const int v : point.views) {
      const Camera& camera = scene.views[v].camera;
      if (camera.Depth(point.position) <= 0) ++behind;
      const Eigen::Vector2d p = camera.Project(point.position);
      worst_px = std::max({worst_px, -p.x(), -p.y(), p.x() - camera.width, p.y() - camera.height});
    }
  }
  EXPECT_EQ(behind, 0);
  EXPECT_LT(worst_px, 4);
}

TEST(Colmap, FountainLoads) {
  const fs::path workspace = RealData("fountain-p11");
  if (!fs::exists(workspace)) GTEST_SKIP() << "BURIN_SHARED_DATA has no fountain-p11";
  const Scene scene = LoadScene({workspace, {}, {}});
  ASSERT_EQ(scene.views.size(), 11U);
  EXPECT_EQ(scene.views[0].camera.width, 1536);
  EXPECT_NEAR(static_cast<double>(scene.points.size()), 14281, 150);
  ExpectPointsInsideTheirImages(scene);
}

TEST(Colmap, HerzJesuLoads) {
  const fs::path workspace = RealData("herz-jesu-p8");
  if (!fs::exists(workspace)) GTEST_SKIP() << "BURIN_SHARED_DATA has no herz-jesu-p8";
  const Scene scene = LoadScene({workspace, {}, {}});
  ASSERT_EQ(scene.views.size(), 8U);
  EXPECT_GT(scene.points.size(), 1000U);
  ExpectPointsInsideTheirImages(scene);
}

// Against the observations that the structure-from-motion run measured: a wrong axis, a wrong pose
// direction or half a pixel of offset would show.
TEST(Colmap, FullSizeTextFountainReprojectsOntoItsObservations) {
  const fs::path workspace = RealData("fountain-p11/full");
  if (!fs::exists(workspace)) GTEST_SKIP() << "BURIN_SHARED_DATA has no fountain-p11/full";
  const Scene scene = LoadScene({workspace, {}, {}});
  ASSERT_EQ(scene.views.size(), 11U);
  EXPECT_NEAR(scene.views[0].camera.fx, 2759.48, 1e-9);
  ExpectPointsInsideTheirImages(scene);

  const ColmapModel model = ReadColmapText(ColmapFilesIn(workspace / "sparse", false));
  std::map<long, Eigen::Vector3d> position_of_id;
  for (const ColmapPoint& point : model.points) {
    position_of_id[static_cast<long>(point.id)] = point.position;
  }
  std::ifstream file(workspace / "sparse/images.txt");
  std::string line;
  std::string name;
  double sum_px = 0;
  Eigen::Vector2d sum_residual = Eigen::Vector2d::Zero();
  int count = 0;
  while (std::getline(file, line)) {
    if (line[0] == '#') continue;
    if (name.empty()) {
      name = line.substr(line.rfind(' ') + 1);
      continue;
    }
    const auto view = std::find_if(scene.views.begin(), scene.views.end(),
                                   [&](const View& v) { return v.name == name; });
    ASSERT_NE(view, scene.views.end()) << name;
    name.clear();
    std::istringstream words(line);
    Eigen::Vector2d observed;
    for (long id = 0; words >> observed.x() >> observed.y() >> id;) {
      if (id < 0) continue;
      const Eigen::Vector2d residual = view->camera.Project(position_of_id.at(id)) - observed;
      sum_px += residual.norm();
      sum_residual += residual;
      ++count;
    }
  }
  ASSERT_GT(count, 10000);
  EXPECT_LT(sum_px / count, 0.7);
  EXPECT_LT((sum_residual / count).norm(), 0.05);
  RecordProperty("mean_reprojection_error_px", std::to_string(sum_px / count));
}

}  // namespace
}  // namespace burin
