// Image masks: a pixel that is zero in its mask is used on neither side of a pair.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "apps/run/pipeline.h"
#include "core/evaluate/evaluation.h"
#include "core/image/gray_image.h"
#include "core/scene/pyramid.h"
#include "core/synthetic/synthetic.h"
#include "core/visibility/facet_pencil.h"
#include "core/visibility/visibility.h"
#include "tests/colmap_testing.h"
#include "tests/small_relief.h"
#include "tests/split_facets.h"
#include "tests/test_scene.h"

namespace burin {
namespace {

constexpr int kWidth = 96;
constexpr int kHeight = 80;

TEST(ImageMasks, TakeTheirPixelsOutOfBothSidesOfAPair) {
  const TriangleMesh mesh = test::OccluderMesh();
  std::vector<Camera> cameras;
  for (const LevelView& view : test::RandomViews(kWidth, kHeight)) cameras.push_back(view.camera);
  const RayCaster caster(mesh);
  const std::vector<CameraPair> pairs = {{0, 1}, {1, 0}};
  std::vector<cv::Mat> masks(cameras.size());
  masks[0] = cv::Mat(kHeight, kWidth, CV_8UC1, cv::Scalar(1));
  masks[0].colRange(30, 50) = 0;
  const auto all = caster.Cast(cameras, pairs, 0);
  const auto masked = caster.Cast(cameras, pairs, 0, masks);
  int64_t left[2] = {0, 0};
  for (int p = 0; p < kWidth * kHeight; ++p) {
    // Reference side.
    const bool out = p % kWidth >= 30 && p % kWidth < 50;
    const bool kept = masked[0].second_visible.Test(0, p);
    EXPECT_EQ(kept, !out && all[0].second_visible.Test(0, p));
    left[0] += kept ? 1 : 0;
  }
  // Second side: by the projection of each pixel's surface point.
  const ViewRays rays(cameras[1]);
  for (size_t k = 0; k < all[1].facet.size(); ++k) {
    const InverseDepthPlane plane =
        MakeFacetPencil(mesh.vertices, mesh.faces[all[1].facet[k]], rays).InverseDepth();
    for (const ImagePixel pixel : all[1].PixelsOf(k)) {
      const double x = cameras[0].Project(rays.SurfacePoint(pixel.x(), pixel.y(), plane)).x();
      if (std::min(std::abs(x - 30), std::abs(x - 50)) < 1e-6) continue;
      const bool out = x > 30 && x < 50;
      const bool kept = masked[1].second_visible.Test(0, pixel.index);
      EXPECT_EQ(kept, !out && all[1].second_visible.Test(0, pixel.index));
      left[1] += kept ? 1 : 0;
    }
  }
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(masked[i].pair_pixels[0], left[i]);
    EXPECT_GT(left[i], 0);
    EXPECT_LT(left[i], all[i].pair_pixels[0]);
  }
}

TEST(ImageMasks, ALevelUsesWhatIsWholeAndAPixelIn) {
  Scene scene;
  View& view = scene.views.emplace_back();
  view.camera = test::LookAt({0, 0, 3}, {0, 0, 0}, 64, 32, 70);
  view.gray = cv::Mat(32, 64, CV_8UC1, cv::Scalar(100));
  view.mask = cv::Mat(32, 64, CV_8UC1, cv::Scalar(255));
  view.mask.at<uint8_t>(16, 31) = 0;
  const std::vector<LevelView> levels = MakeLevelViews(scene, 1, Eigen::Vector3d::Zero(), 1);
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 32; ++x) {
      const bool out = std::abs(x - 15) <= 1 && std::abs(y - 8) <= 1;
      EXPECT_EQ(levels[0].mask.at<uint8_t>(y, x), out ? 0 : 255) << x << " " << y;
    }
  }
}

// A masked pixel's grey level has no weight in anything that the energy makes of a level: its image (and
// so its spline), contrast and noise.
TEST(ImageMasks, AMaskedGreyLevelHasNoWeight) {
  test::Random random(3);
  for (const int type : {CV_8UC1, CV_32FC1}) {
    for (const bool half_plane : {false, true}) {
      Scene scene;
      View& view = scene.views.emplace_back();
      view.camera = test::LookAt({0, 0, 3}, {0, 0, 0}, 128, 96, 140);
      cv::Mat1f gray(96, 128);
      for (float& level : gray) level = static_cast<float>(100 + 50 * random.Uniform());
      view.mask = cv::Mat(96, 128, CV_8UC1, cv::Scalar(255));
      view.mask(half_plane ? cv::Rect(0, 0, 64, 96) : cv::Rect(60, 40, 1, 1)) = 0;
      gray.convertTo(view.gray, type);
      Scene other = scene;
      other.views[0].gray = view.gray.clone();
      other.views[0].gray.setTo(230, view.mask == 0);
      for (const int level : {0, 1, 2}) {
        const auto made = MakeLevelViews(scene, level, Eigen::Vector3d::Zero(), 1);
        const auto changed = MakeLevelViews(other, level, Eigen::Vector3d::Zero(), 1);
        EXPECT_EQ(cv::norm(made[0].image, changed[0].image, cv::NORM_INF), 0) << level;
        EXPECT_EQ(made[0].contrast, changed[0].contrast);
        EXPECT_EQ(made[0].photo_noise_sigma, changed[0].photo_noise_sigma);
        EXPECT_EQ(made[0].noise_sigma, changed[0].noise_sigma);
        EXPECT_GT(made[0].contrast, 10);
      }
      const auto made = MakeLevelViews(scene, 0, Eigen::Vector3d::Zero(), 1);
      EXPECT_EQ(made[0].image.type(), type);
      EXPECT_EQ(cv::norm(made[0].image, view.gray, cv::NORM_INF, view.mask), 0);
    }
  }
}

TEST(ImageMasks, AreReadByColmapsNames) {
  const TempFolder folder;
  const Scene scene = TinyScene();
  WriteColmapScene(scene, folder.path() / "scene", true);
  const std::filesystem::path masks = folder.path() / "masks";
  const auto refused = [&](const std::string& part) {
    try {
      LoadScene({folder.path() / "scene", {}, masks});
      ADD_FAILURE() << part;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(part));
    }
  };
  refused("folder is missing");
  std::filesystem::create_directories(masks);
  refused("no image has a mask; that of view0.png would be called view0.png.png");
  cv::Mat mask(4, 6, CV_8UC1, cv::Scalar(0));
  mask.at<uint8_t>(1, 2) = 7;
  WriteGrayImage(mask, masks / "view1.png.png");
  const Scene read = LoadScene({folder.path() / "scene", {}, masks});
  EXPECT_TRUE(read.views[0].mask.empty());
  EXPECT_EQ(cv::countNonZero(read.views[1].mask), 1);
  EXPECT_NE(read.views[1].mask.at<uint8_t>(1, 2), 0);
  WriteGrayImage(cv::Mat(4, 5, CV_8UC1, cv::Scalar(0)), masks / "view0.png.png");
  refused("view0.png.png: image size: is 5 x 4 but camera 1 is 6 x 4");
}

// Photographs 6 x 4 of TinyScene with masks by other names; which views have one, and what is said.
TEST(ImageMasks, AreFoundByTheNamesThatProgramsGive) {
  for (const std::string name :
       {"view1.png", "VIEW1_mask.PNG", "view1.mask.tif", "mask_view1.png"}) {
    const TempFolder folder;
    WriteColmapScene(TinyScene(), folder.path() / "scene", true);
    cv::Mat mask(4, 6, CV_8UC1, cv::Scalar(255));
    mask.colRange(0, 3) = 0;
    std::filesystem::create_directories(folder.path() / "masks");
    ASSERT_TRUE(cv::imwrite((folder.path() / "masks" / name).string(), mask));
    ASSERT_TRUE(cv::imwrite((folder.path() / "masks" / "other.png").string(), mask));
    const Scene scene = LoadScene({folder.path() / "scene", {}, folder.path() / "masks"});
    EXPECT_TRUE(scene.views[0].mask.empty());
    EXPECT_EQ(cv::norm(scene.views[1].mask, mask, cv::NORM_INF), 0) << name;
    EXPECT_THAT(scene.notes,
                testing::ElementsAre(
                    testing::AllOf(testing::HasSubstr("1 of 2 views has a mask; that of view0.png "
                                                      "would be called view0.png.png; 1 files of "),
                                   testing::HasSubstr("fit no view, the first is other.png")),
                    "1 of 2 views have a mask; 75.0 % of all pixels are used"));
  }
}

// What programs that cut out backgrounds save: the cut in the alpha, over white in masks, over anything in photographs.
TEST(ImageMasks, AlphaIsAMask) {
  const TempFolder folder;
  const Scene scene = TinyScene();
  WriteColmapScene(scene, folder.path() / "scene", true);
  cv::Mat alpha(4, 6, CV_8UC1, cv::Scalar(255));
  alpha.rowRange(0, 2) = 0;
  alpha.at<uint8_t>(2, 2) = 128;  // blended with what is behind
  const cv::Mat gray = scene.views[0].gray;
  const auto write = [&](const std::filesystem::path& path, const cv::Mat& levels) {
    cv::Mat cut;
    cv::merge(std::vector<cv::Mat>{levels, levels, levels, alpha}, cut);
    std::filesystem::create_directories(path.parent_path());
    ASSERT_TRUE(cv::imwrite(path.string(), cut));
  };
  write(folder.path() / "scene/images/view0.png", gray);
  const Scene cut = LoadScene({folder.path() / "scene", {}, {}});
  EXPECT_EQ(cv::norm(cut.views[0].mask, alpha == 255, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(cut.views[0].gray, gray, cv::NORM_INF), 0);
  EXPECT_TRUE(cut.views[1].mask.empty());
  EXPECT_THAT(cut.notes,
              testing::Contains("1 photographs have transparent pixels, which are not used"));
  write(folder.path() / "masks/view1.png.png", cv::Mat(4, 6, CV_8UC1, cv::Scalar(255)));
  const Scene masked = LoadScene({folder.path() / "scene", {}, folder.path() / "masks"});
  EXPECT_EQ(cv::norm(masked.views[1].mask, alpha == 255, cv::NORM_INF), 0);
  // Opaque everywhere is no mask.
  alpha.setTo(255);
  write(folder.path() / "scene/images/view0.png", gray);
  EXPECT_TRUE(LoadScene({folder.path() / "scene", {}, {}}).views[0].mask.empty());
}

TEST(ImageMasks, BlackAlongTheBorderOfAllPhotographsIsNoPicture) {
  const TempFolder folder;
  Scene scene = TinyScene();
  View third = scene.views[1];
  third.name = "view2.png";
  third.camera.translation.x() += 1;
  scene.views.push_back(third);
  for (View& view : scene.views) {
    view.camera = scene.views[0].camera;
    view.camera.translation.x() += static_cast<double>(&view - scene.views.data());
    view.gray = cv::Mat(4, 6, CV_8UC1, cv::Scalar(90));
    view.gray.at<uint8_t>(0, 0) = view.gray.at<uint8_t>(0, 1) = 0;
    view.gray.at<uint8_t>(2, 2) = 0;  // black, but of the picture
  }
  scene.views[1].gray.at<uint8_t>(3, 5) = 0;  // in one photograph only
  scene.points.clear();
  for (View& view : scene.views) view.origin.camera_id = 1;
  WriteColmapScene(scene, folder.path(), true);
  const Scene read = LoadScene({folder.path(), {}, {}});
  for (const View& view : read.views) {
    ASSERT_FALSE(view.mask.empty());
    EXPECT_EQ(cv::countNonZero(view.mask == 0), 2);
    EXPECT_EQ(view.mask.at<uint8_t>(0, 1), 0);
  }
  EXPECT_THAT(read.notes, testing::Contains(testing::HasSubstr(
                              "view0.png and 2 more: 8.3 % of the picture is 0 along its border")));
}

// As shares of pixels; the largest grey level is the whole object, and what the lens takes from outside the photograph is
// none.
TEST(ImageMasks, ThatMeanTheObjectKeepTheirGreyLevels) {
  const TempFolder folder;
  WriteColmapScene(TinyScene(), folder.path() / "scene", true);
  const std::filesystem::path masks = folder.path() / "masks";
  std::filesystem::create_directories(masks);
  SceneSource source = {folder.path() / "scene", {}, {}, MaskMeaning::kObject};
  EXPECT_THROW(LoadScene(source), InputError);  // none names a mask
  cv::Mat mask(4, 6, CV_8UC1, cv::Scalar(0));
  mask.at<uint8_t>(1, 2) = 50;
  mask.at<uint8_t>(1, 3) = 100;
  WriteGrayImage(mask, masks / "view1.png.png");
  source.masks = masks;
  const Scene read = LoadScene(source);
  EXPECT_TRUE(read.views[0].object.empty());
  EXPECT_EQ(cv::countNonZero(read.views[1].mask), 2);
  EXPECT_EQ(cv::countNonZero(read.views[1].object), 2);
  EXPECT_NEAR(read.views[1].object.at<uint8_t>(1, 2), 127.5, 0.6);
  EXPECT_EQ(read.views[1].object.at<uint8_t>(1, 3), 255);
  source.masks_mean = MaskMeaning::kIgnore;
  EXPECT_TRUE(LoadScene(source).views[1].object.empty());
}

TEST(ImageMasks, ALevelHasTheObjectsShare) {
  Scene scene;
  View& view = scene.views.emplace_back();
  view.camera = test::LookAt({0, 0, 3}, {0, 0, 0}, 64, 32, 70);
  view.gray = cv::Mat(32, 64, CV_8UC1, cv::Scalar(100));
  view.object = cv::Mat(32, 64, CV_8UC1, cv::Scalar(0));
  view.object.at<uint8_t>(10, 20) = 255;
  view.photographed = cv::Mat(32, 64, CV_8UC1, cv::Scalar(255));
  view.photographed.at<uint8_t>(0, 0) = 0;
  const LevelView level = MakeLevelViews(scene, 1, Eigen::Vector3d::Zero(), 1)[0];
  EXPECT_FLOAT_EQ(level.object(5, 10), 0.25F);
  EXPECT_EQ(cv::countNonZero(level.object), 1);
  EXPECT_EQ(level.photographed(0, 0), 0);
  EXPECT_EQ(cv::countNonZero(level.photographed), 16 * 32 - 1);
}

// Something that moved through two views, and masks that leave it out.
TEST(ImageMasks, LeavingOutAMovingObjectMendsTheMesh) {
  SyntheticOptions options = test::SmallReliefOptions(6);
  const SyntheticScene clean = MakeSyntheticScene(options);
  options.stress = StressKind::kMover;
  SyntheticScene moved = MakeSyntheticScene(options);
  const auto error = [&](const Scene& scene) {
    return RmseToTruthMesh(RunPipeline(scene, moved.init, test::SplitFacets()).mesh, clean.truth,
                           20000);
  };
  const double without = error(moved.scene);
  for (size_t i = 0; i < moved.scene.views.size(); ++i) {
    cv::Mat difference;
    cv::absdiff(moved.scene.views[i].gray, clean.scene.views[i].gray, difference);
    cv::Mat1b mask(difference.size(), 255);
    for (int y = 0; y < mask.rows; ++y) {
      for (int x = 0; x < mask.cols; ++x) {
        // The disc's pixels, but for the few where it happens to have the scene's grey.
        const cv::Rect around = cv::Rect(x - 2, y - 2, 5, 5) & cv::Rect(0, 0, mask.cols, mask.rows);
        if (cv::countNonZero(difference(around)) > 0) mask(y, x) = 0;
      }
    }
    moved.scene.views[i].mask = mask;
  }
  const double with = error(moved.scene);
  const double best = error(clean.scene);
  RecordProperty("without_px", std::to_string(without / clean.footprint));
  RecordProperty("with_px", std::to_string(with / clean.footprint));
  RecordProperty("clean_px", std::to_string(best / clean.footprint));
  EXPECT_GT(without, 1.01 * best);
  EXPECT_LT(with - best, 0.3 * (without - best));
}

}  // namespace
}  // namespace burin
