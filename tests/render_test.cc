#include "core/visibility/render.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "core/image/picture.h"
#include "core/support/error.h"
#include "core/support/parallel.h"
#include "core/visibility/ray_render.h"

namespace burin {
namespace {

Camera TestCamera(int width = 80, int height = 60) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = 90;
  camera.fy = 85;
  camera.cx = 0.52 * width;
  camera.cy = 0.47 * height;
  camera.rotation =
      Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  camera.translation = {0.3, -0.2, 1.5};
  return camera;
}

// A square of half-width `half` around the optical axis at camera depth z, tilted by `slope` along
// the camera's x, facing the camera; given in the world frame.
TriangleMesh SquareBefore(const Camera& camera, double z, double half, double slope) {
  TriangleMesh mesh;
  for (const auto& [x, y] :
       {std::pair{-1, -1}, std::pair{1, -1}, std::pair{1, 1}, std::pair{-1, 1}}) {
    const Eigen::Vector3d in_camera(half * x, half * y, z + slope * half * x);
    mesh.vertices.push_back(camera.rotation.transpose() * (in_camera - camera.translation));
  }
  mesh.faces = {{0, 2, 1}, {0, 3, 2}};
  return mesh;
}

TriangleMesh SphereAt(const Eigen::Vector3d& centre, double radius, int n) {
  TriangleMesh mesh;
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j < 2 * n; ++j) {
      const double polar = M_PI * i / n;
      const double azimuth = M_PI * j / n;
      mesh.vertices.push_back(centre + radius * Eigen::Vector3d(std::sin(polar) * std::cos(azimuth),
                                                                std::sin(polar) * std::sin(azimuth),
                                                                std::cos(polar)));
    }
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < 2 * n; ++j) {
      const int a = i * 2 * n + j;
      const int b = i * 2 * n + (j + 1) % (2 * n);
      mesh.faces.emplace_back(a, a + 2 * n, b + 2 * n);
      mesh.faces.emplace_back(a, b + 2 * n, b);
    }
  }
  return mesh;
}

bool SameBytes(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() &&
         std::memcmp(a.data, b.data, a.total() * a.elemSize()) == 0;
}

TEST(RenderDepth, PlaneIsExactAtPixelCentres) {
  const Camera camera = TestCamera();
  const double z = 2.0;
  const double slope = 0.3;
  const cv::Mat1f depth = RenderDepth(MeshRays(SquareBefore(camera, z, 20, slope)), camera);
  for (int row = 0; row < camera.height; ++row) {
    for (int col = 0; col < camera.width; ++col) {
      // Z = z + slope X with X = Z (col + 0.5 - cx) / fx.
      const double exact = z / (1 - slope * (col + 0.5 - camera.cx) / camera.fx);
      ASSERT_NEAR(depth(row, col), exact, 3e-7 * exact) << row << " " << col;
    }
  }
}

TEST(RenderDepth, CoversTheProjectedSquareAndNothingElse) {
  const Camera camera = TestCamera();
  const cv::Mat1f depth = RenderDepth(MeshRays(SquareBefore(camera, 2.0, 0.5, 0)), camera);
  for (int row = 0; row < camera.height; ++row) {
    for (int col = 0; col < camera.width; ++col) {
      const double x = 2.0 * (col + 0.5 - camera.cx) / camera.fx;
      const double y = 2.0 * (row + 0.5 - camera.cy) / camera.fy;
      EXPECT_EQ(depth(row, col) > 0, std::abs(x) <= 0.5 && std::abs(y) <= 0.5);
    }
  }
}

TEST(RenderDepth, SilhouetteOfASphereHasItsArea) {
  Camera camera;
  camera.width = camera.height = 200;
  camera.fx = camera.fy = 300;
  camera.cx = camera.cy = 100;
  const double distance = 5;
  const double radius = 1;
  const cv::Mat1f depth = RenderDepth(MeshRays(SphereAt({0, 0, distance}, radius, 100)), camera);
  // The cone of tangents meets the image plane in a circle of radius f r / sqrt(d^2 - r^2).
  const double pixels = 300 * radius / std::sqrt(distance * distance - radius * radius);
  EXPECT_NEAR(cv::countNonZero(depth), M_PI * pixels * pixels, 0.005 * M_PI * pixels * pixels);
  EXPECT_NEAR(depth(100, 100), distance - radius, 1e-3);
}

TEST(RenderDepth, NothingBehindTheCamera) {
  const Camera camera = TestCamera();
  EXPECT_EQ(cv::countNonZero(RenderDepth(MeshRays(SquareBefore(camera, -2.0, 20, 0)), camera)), 0);
  EXPECT_EQ(cv::countNonZero(RenderDepth(MeshRays(TriangleMesh()), camera)), 0);
}

TEST(RenderDepth, FarFromTheOrigin) {
  Camera camera = TestCamera();
  TriangleMesh mesh = SquareBefore(camera, 2.0, 20, 0);
  const Eigen::Vector3d far(4.0e5, 5.0e6, 300);
  for (Eigen::Vector3d& vertex : mesh.vertices) vertex += far;
  camera.translation -= camera.rotation * far;
  const cv::Mat1f depth = RenderDepth(MeshRays(mesh), camera);
  for (const float z : depth) ASSERT_NEAR(z, 2.0, 1e-6);
}

TEST(RenderShaded, ShowsFormAndBackground) {
  Camera camera;
  camera.width = camera.height = 100;
  camera.fx = camera.fy = 150;
  camera.cx = camera.cy = 50;
  RenderOptions options;
  options.background = {200, 220, 240};
  for (const bool smooth : {false, true}) {
    options.smooth = smooth;
    const cv::Mat3b picture = RenderShaded(SphereAt({0, 0, 5}, 1, 40), camera, options);
    EXPECT_EQ(picture(0, 0), options.background);
    cv::Scalar mean, deviation;
    cv::meanStdDev(picture(cv::Rect(30, 30, 40, 40)), mean, deviation);
    EXPECT_GT(deviation[0], 10);                        // shading varies over the sphere
    EXPECT_GT(picture(38, 38)[0], picture(62, 62)[0]);  // the key light is at the upper left
    EXPECT_LT(std::abs(picture(50, 50)[0] - picture(50, 50)[2]), 20);  // grey
  }
  // Seen from behind: reddish.
  TriangleMesh inverted = SphereAt({0, 0, 5}, 1, 40);
  for (Eigen::Vector3i& face : inverted.faces) std::swap(face[1], face[2]);
  const cv::Vec3b center = RenderShaded(inverted, camera, options)(50, 50);
  EXPECT_GT(center[2], center[0] + 40);
}

TEST(RenderShaded, SameBytesForAnyThreadCount) {
  const Camera camera = TestCamera();
  const TriangleMesh mesh = SphereAt(camera.Center() + 4 * camera.Ray(40, 30), 1, 20);
  const ThreadScope one_thread(1);
  const cv::Mat3b one = RenderShaded(mesh, camera);
  const ThreadScope two_threads(2);
  EXPECT_TRUE(SameBytes(one, RenderShaded(mesh, camera)));
}

TEST(RenderVertexScalar, ColoursFollowTheScale) {
  const Camera camera = TestCamera();
  const TriangleMesh mesh = SquareBefore(camera, 2.0, 20, 0);
  ColorScale scale;
  scale.min = -1;
  scale.max = 1;
  scale.label = "error [mm]";
  const auto center_color = [&](double value) {
    const cv::Mat3b picture =
        RenderVertexScalar(mesh, camera, std::vector<double>(4, value), scale);
    EXPECT_EQ(picture.rows, camera.height);
    EXPECT_GT(picture.cols, camera.width);  // the colour bar
    return picture(30, 40);
  };
  EXPECT_GT(center_color(1)[2], center_color(1)[0] + 60);    // red
  EXPECT_GT(center_color(-1)[0], center_color(-1)[2] + 60);  // blue
  EXPECT_NEAR(center_color(0)[0], center_color(0)[2], 6);    // grey
  EXPECT_EQ(center_color(5), center_color(1));               // clamped
  EXPECT_NEAR(center_color(std::numeric_limits<double>::quiet_NaN())[0], 128, 60);
  EXPECT_EQ(ScaleColor(scale, std::nan("")), cv::Vec3b(128, 128, 128));
  // Viridis: dark blue to yellow, lightness rising.
  scale.min = 0;
  int last = -1;
  for (int k = 0; k <= 10; ++k) {
    const cv::Vec3b color = ScaleColor(scale, 0.1 * k);
    const int light = 2 * color[2] + 5 * color[1] + color[0];
    EXPECT_GT(light, last);
    last = light;
  }
}

TEST(SideBySide, PutsPicturesInARow) {
  const cv::Mat3b red(100, 120, cv::Vec3b(0, 0, 255));
  const cv::Mat1b gray(200, 100, uchar{90});
  const cv::Mat3b row = SideBySide({red, gray}, {"before", "after a long caption, shrunk to fit"});
  EXPECT_GT(row.rows, 100);
  EXPECT_GE(row.cols, 120 + 50);
  EXPECT_LT(row.cols, 120 + 50 + 30);
  EXPECT_EQ(row(row.rows - 50, 60), cv::Vec3b(0, 0, 255));
  EXPECT_EQ(row(row.rows - 50, row.cols - 25), cv::Vec3b(90, 90, 90));
  cv::Mat dark;
  cv::inRange(row(cv::Rect(0, 0, 120, row.rows - 100)), cv::Scalar(0, 0, 0),
              cv::Scalar(120, 120, 120), dark);
  EXPECT_GT(cv::countNonZero(dark), 20);  // the caption
}

TEST(WritePicture, RoundTripsAndSaysWhyNot) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "burin_pictures";
  std::filesystem::create_directories(folder);
  const cv::Mat3b picture(20, 30, cv::Vec3b(10, 200, 90));
  WritePicture(folder / "a.png", picture);
  EXPECT_TRUE(SameBytes(cv::imread((folder / "a.png").string()), picture));
  EXPECT_THROW(WritePicture(folder / "a.unknown", picture), InputError);
  EXPECT_THROW(WritePicture(folder / "missing" / "a.png", picture), InputError);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace burin
