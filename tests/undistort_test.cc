#include "core/scene/undistort.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>

#include "core/scene/formats/colmap.h"
#include "core/scene/formats/scene_loader.h"
#include "tests/colmap_testing.h"

namespace burin {
namespace {

constexpr int kWidth = 160;
constexpr int kHeight = 120;

Camera TestCamera(double fx, double fy) {
  Camera camera;
  camera.width = kWidth;
  camera.height = kHeight;
  camera.fx = fx;
  camera.fy = fy;
  camera.cx = 78.3;
  camera.cy = 61.9;
  return camera;
}

// Grey level of the scene in direction (u, v, 1); waves of about 40 pixels.
double Level(const Eigen::Vector2d& direction) {
  return 128 + 60 * std::sin(33 * direction.x() + 5 * direction.y()) +
         50 * std::cos(31 * direction.y() - 7 * direction.x());
}

// The lens as COLMAP documents it, written down independently of OpenCV.
Eigen::Vector2d Distort(const Eigen::Vector2d& p, const Lens& d) {
  if (d.measured != 0) {
    Eigen::Vector2d photographed = p;
    for (int i = 0; i < 200; ++i) photographed = p / (1 + d.measured * photographed.squaredNorm());
    return photographed;
  }
  const double u = p.x();
  const double v = p.y();
  const double r2 = u * u + v * v;
  const double radial = r2 * (d.brown[0] + r2 * (d.brown[1] + r2 * d.brown[4]));
  return {u + u * radial + 2 * d.brown[2] * u * v + d.brown[3] * (r2 + 2 * u * u),
          v + v * radial + 2 * d.brown[3] * u * v + d.brown[2] * (r2 + 2 * v * v)};
}

Eigen::Vector2d InvertDistortion(const Eigen::Vector2d& distorted, const Lens& d) {
  if (d.measured != 0) return distorted * (1 + d.measured * distorted.squaredNorm());
  Eigen::Vector2d p = distorted;
  for (int i = 0; i < 200; ++i) p += distorted - Distort(p, d);
  EXPECT_LT((Distort(p, d) - distorted).norm(), 1e-13);
  return p;
}

// What the lens photographs, in 16 bits so that rounding does not hide small errors.
cv::Mat Photograph(const Camera& camera, const Lens& distortion) {
  cv::Mat image(kHeight, kWidth, CV_16UC1);
  for (int row = 0; row < kHeight; ++row) {
    for (int col = 0; col < kWidth; ++col) {
      const Eigen::Vector2d distorted((col + 0.5 - camera.cx) / camera.fx,
                                      (row + 0.5 - camera.cy) / camera.fy);
      const double level = Level(InvertDistortion(distorted, distortion));
      image.at<std::uint16_t>(row, col) = static_cast<std::uint16_t>(std::lround(level * 257));
    }
  }
  return image;
}

// Largest deviation from what the pinhole camera sees, over pixels whose source and its taps lie in
// the photograph.
double MaxError(const cv::Mat& undistorted, const Camera& camera, const Lens& distortion) {
  double worst = 0;
  int used = 0;
  for (int row = 0; row < kHeight; ++row) {
    for (int col = 0; col < kWidth; ++col) {
      const Eigen::Vector2d p((col + 0.5 - camera.cx) / camera.fx,
                              (row + 0.5 - camera.cy) / camera.fy);
      const Eigen::Vector2d source = Distort(p, distortion);
      const double x = source.x() * camera.fx + camera.cx;
      const double y = source.y() * camera.fy + camera.cy;
      if (x < 2.5 || y < 2.5 || x > kWidth - 2.5 || y > kHeight - 2.5) continue;
      ++used;
      worst = std::max(worst, std::abs(undistorted.at<float>(row, col) - Level(p)));
    }
  }
  EXPECT_GT(used, kWidth * kHeight * 3 / 4);
  return worst;
}

struct LensCase {
  const char* model;
  std::string parameters;  // as in cameras.txt, after width and height
  double fx, fy;
  Lens distortion;
};

// Also what a reader would make of it that takes COLMAP's pixel centres for OpenCV's, or the other
// way round: the principal point is half a pixel off, and the tolerance must tell.
TEST(Undistort, LoadedImagesShowWhatThePinholeCameraSees) {
  constexpr double kTolerance = 0.03;  // grey levels
  const LensCase lenses[] = {
      {"SIMPLE_RADIAL", "210 78.3 61.9 -0.3", 210, 210, {{-0.3, 0, 0, 0, 0}}},
      {"SIMPLE_RADIAL", "210 78.3 61.9 0.2", 210, 210, {{0.2, 0, 0, 0, 0}}},
      {"RADIAL", "210 78.3 61.9 -0.35 0.2", 210, 210, {{-0.35, 0.2, 0, 0, 0}}},
      {"OPENCV", "210 200 78.3 61.9 -0.3 0.1 0.02 -0.03", 210, 200, {{-0.3, 0.1, 0.02, -0.03, 0}}},
  };
  for (const LensCase& lens : lenses) {
    SCOPED_TRACE(std::string(lens.model) + " " + lens.parameters);
    const TempFolder folder;
    const Camera camera = TestCamera(lens.fx, lens.fy);
    WriteBytes(folder.path() / "sparse/cameras.txt",
               "1 " + std::string(lens.model) + " 160 120 " + lens.parameters + "\n");
    WriteBytes(folder.path() / "sparse/images.txt",
               "1 1 0 0 0 0 0 0 1 a.png\n\n2 1 0 0 0 1 0 0 1 b.png\n\n");
    WriteBytes(folder.path() / "sparse/points3D.txt", "");
    const cv::Mat photograph = Photograph(camera, lens.distortion);
    std::filesystem::create_directories(folder.path() / "images");
    for (const char* name : {"a.png", "b.png"}) {
      ASSERT_TRUE(cv::imwrite((folder.path() / "images" / name).string(), photograph));
    }

    const Scene scene = LoadScene({folder.path(), {}, {}});
    for (const View& view : scene.views) {
      EXPECT_EQ(view.camera.fx, lens.fx);
      EXPECT_EQ(view.camera.fy, lens.fy);
      EXPECT_NEAR(view.camera.cx, camera.cx, 1e-9);
      EXPECT_NEAR(view.camera.cy, camera.cy, 1e-9);
      ASSERT_EQ(view.gray.type(), CV_32FC1);
      EXPECT_LT(MaxError(view.gray, camera, lens.distortion), kTolerance);
    }

    cv::Mat levels;
    photograph.convertTo(levels, CV_32F, 1 / 257.0);
    for (const double shift : {-0.5, 0.5}) {
      Camera wrong = camera;
      wrong.cx += shift;
      wrong.cy += shift;
      const double error =
          MaxError(Undistort(levels, wrong, lens.distortion), camera, lens.distortion);
      EXPECT_GT(error, 10 * kTolerance) << "shift " << shift;
    }
  }
}

TEST(Undistort, EightBitImagesDifferByRoundingOnly) {
  const Lens distortion = {{-0.3, 0.1, 0.02, -0.03, 0.05}};
  const Camera camera = TestCamera(210, 200);
  cv::Mat levels, bytes;
  Photograph(camera, distortion).convertTo(levels, CV_32F, 1 / 257.0);
  levels.convertTo(bytes, CV_8U);
  const cv::Mat undistorted = Undistort(bytes, camera, distortion);
  ASSERT_EQ(undistorted.type(), CV_8UC1);
  cv::Mat as_float;
  undistorted.convertTo(as_float, CV_32F);
  EXPECT_LT(MaxError(as_float, camera, distortion), 1.4);  // two roundings, the first amplified
}

TEST(Undistort, TheLensOfVisualSfmGoesTheOtherWay) {
  for (const double radial : {-0.3, 0.2}) {
    Lens lens;
    lens.measured = radial;
    const Camera camera = TestCamera(210, 200);
    cv::Mat levels;
    Photograph(camera, lens).convertTo(levels, CV_32F, 1 / 257.0);
    EXPECT_LT(MaxError(Undistort(levels, camera, lens), camera, lens), 0.03) << radial;
    EXPECT_GT(MaxError(levels, camera, lens), 1);
  }
}

// Without distortion every pixel is its own source.
TEST(Undistort, NoDistortionIsTheIdentity) {
  const Camera camera = TestCamera(210, 200);
  cv::Mat levels;
  Photograph(camera, Lens()).convertTo(levels, CV_8U, 1 / 257.0);
  EXPECT_EQ(cv::norm(Undistort(levels, camera, Lens()), levels, cv::NORM_INF), 0);
}

// Pixels of the undistorted image that the lens takes from outside the photograph, or from beyond where
// it folds back, are said to be so.
TEST(Undistort, PixelsWithoutAPhotographAreNamed) {
  const Camera camera = TestCamera(210, 200);
  EXPECT_EQ(cv::countNonZero(PhotographedPixels(camera, Lens())), kWidth * kHeight);
  const Lens barrel = {{-0.1, 0, 0, 0, 0}};
  EXPECT_EQ(cv::countNonZero(PhotographedPixels(camera, barrel)), kWidth * kHeight);
  const Lens pincushion = {{0.2, 0.05, 0.01, -0.02, 0.003}};
  const cv::Mat inside = PhotographedPixels(camera, pincushion);
  int outside_count = 0;
  for (int i = 0; i < kHeight; ++i) {
    for (int j = 0; j < kWidth; ++j) {
      const Eigen::Vector2d photographed = Distort(
          {(j + 0.5 - camera.cx) / camera.fx, (i + 0.5 - camera.cy) / camera.fy}, pincushion);
      const double x = photographed.x() * camera.fx + camera.cx;
      const double y = photographed.y() * camera.fy + camera.cy;
      const double margin = std::min({x, y, kWidth - x, kHeight - y});
      if (std::abs(margin) > 1e-3) {
        EXPECT_EQ(inside.at<unsigned char>(i, j), margin > 0 ? 255 : 0);
      }
      outside_count += margin < 0 ? 1 : 0;
    }
  }
  EXPECT_GT(outside_count, kWidth);
  // r (1 - 12 r^2) grows up to r = 1/6; r (1 - 16/3 r^2) up to r = 1/4, where it is 1/6.
  const double fold = camera.fx / 6;
  for (const Lens& lens : {Lens{{-12, 0, 0, 0, 0}}, Lens{{0, 0, 0, 0, 0}, -16.0 / 3}}) {
    const cv::Mat before = PhotographedPixels(camera, lens);
    const double count = CV_PI * fold * fold * camera.fy / camera.fx;
    EXPECT_NEAR(cv::countNonZero(before), count, 0.02 * count);
  }
}

TEST(Undistort, AbsurdCoefficientsAndOnePixelImagesAreHarmless) {
  Camera camera = TestCamera(210, 200);
  const cv::Mat image(kHeight, kWidth, CV_8UC1, cv::Scalar(90));
  for (const double k : {1e300, -1e300, 1e30, -1e9}) {
    const cv::Mat result = Undistort(image, camera, {{k, -k, k, k, k}});
    EXPECT_EQ(cv::norm(result, image, cv::NORM_INF), 0);
  }
  camera.width = camera.height = 1;
  const cv::Mat pixel(1, 1, CV_8UC1, cv::Scalar(90));
  EXPECT_EQ(Undistort(pixel, camera, {{-0.3, 0, 0, 0, 0}}).at<unsigned char>(0, 0), 90);
}

}  // namespace
}  // namespace burin
