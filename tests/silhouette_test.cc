// Which points lie near an occlusion boundary, on a square in front of a wall.
#include "core/visibility/silhouette.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "core/support/error.h"
#include "core/visibility/ray_render.h"
#include "tests/test_scene.h"

namespace burin {
namespace {

// A square of half width 0.5 at z = 1 before a wall at z = 0, seen from z = 5; 100 px a unit on the
// wall.
struct SquareScene {
  SquareScene() {
    test::AppendGrid(&mesh, 4, 0, 0, 2, [](double, double) { return 0.0; });
    test::AppendGrid(&mesh, 4, 0, 0, 0.5, [](double, double) { return 1.0; });
    camera = test::LookAt({0, 0, 5}, {0, 0, 0}, 600, 600, 500);
    depth = RenderDepth(MeshRays(mesh), camera);
  }
  bool Near(const Eigen::Vector3d& point, double radius_px = 4) const {
    SilhouetteOptions options;
    options.radius_px = radius_px;
    return NearSilhouettes({point}, {camera}, {depth}, options)[0] != 0;
  }
  TriangleMesh mesh;
  Camera camera;
  cv::Mat1f depth;
};

TEST(Silhouette, NearIsWithinTheRadiusOfAStep) {
  const SquareScene scene;
  // On the square 125 px a unit: 0.02 is 2.5 px.
  EXPECT_TRUE(scene.Near({0.48, 0, 1}));
  EXPECT_FALSE(scene.Near({0.44, 0, 1}));
  EXPECT_TRUE(scene.Near({0.44, 0, 1}, 10));
  // The square's edge hides the wall up to 0.625.
  EXPECT_TRUE(scene.Near({0.65, 0, 0}));
  EXPECT_FALSE(scene.Near({0.70, 0, 0}));
  // The border of the wall against nothing.
  EXPECT_TRUE(scene.Near({1.98, 0, 0}));
}

TEST(Silhouette, HiddenPointsAndPointsOutsideAreNotNear) {
  const SquareScene scene;
  EXPECT_FALSE(scene.Near({0.60, 0, 0}));  // behind the square's edge
  EXPECT_FALSE(scene.Near({0.48, 0, 6}));  // behind the camera
  EXPECT_FALSE(scene.Near({30, 0, 0}));
}

TEST(Silhouette, AnyViewThatSeesItDecides) {
  const SquareScene scene;
  const Camera oblique = test::LookAt({3, 0, 4}, {0, 0, 0}, 600, 600, 500);
  const Eigen::Vector3d point(-0.45, 0, 1);
  const std::vector<Camera> cameras = {scene.camera, oblique};
  std::vector<cv::Mat1f> depth = {scene.depth, RenderDepth(MeshRays(scene.mesh), oblique)};
  SilhouetteOptions options;
  options.radius_px = 5;
  EXPECT_FALSE(NearSilhouettes({point}, {scene.camera}, {scene.depth}, options)[0] != 0);
  EXPECT_TRUE(NearSilhouettes({point}, cameras, depth, options)[0] != 0);
  depth[1] = cv::Mat1f();  // a view without a map says nothing
  EXPECT_FALSE(NearSilhouettes({point}, cameras, depth, options)[0] != 0);
}

TEST(Silhouette, DepthMapsReadBackAndFaultsAreNamed) {
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / "burin_silhouette_depth";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  Scene scene;
  for (const char* name : {"a.jpg", "b.png", "c.png"}) {
    View view;
    view.name = name;
    view.camera = test::LookAt({0, 0, 5}, {0, 0, 0}, 60, 40, 50);
    scene.views.push_back(view);
  }
  EXPECT_THROW(ReadDepthMaps(folder, scene, 1), InputError);  // none at all
  cv::imwrite((folder / "a.tiff").string(), cv::Mat1f(40, 60, 2.5F));
  cv::imwrite((folder / "b_depth.png").string(), cv::Mat(20, 30, CV_16U, cv::Scalar(5000)));
  const std::vector<cv::Mat1f> maps = ReadDepthMaps(folder, scene, 0.001);
  EXPECT_EQ(maps[0](3, 4), 2.5F);
  EXPECT_EQ(maps[1](3, 4), 5.0F);
  EXPECT_TRUE(maps[2].empty());
  cv::imwrite((folder / "c.tiff").string(), cv::Mat1f(60, 40, 2.5F));
  EXPECT_THROW(ReadDepthMaps(folder, scene, 1), InputError);  // another shape
  std::ofstream(folder / "c.tiff") << "not a picture";
  EXPECT_THROW(ReadDepthMaps(folder, scene, 1), InputError);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace burin
