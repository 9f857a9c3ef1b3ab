// Pair selection on configurations whose answer is known.
#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "selection/mesh_parallax_pairs.h"
#include "selection/pair_selection.h"
#include "selection/sparse_point_pairs.h"
#include "tests/test_scene.h"

namespace burin {
namespace {

// Cameras at distance 5 from the origin, `degrees` from the z axis in the x-z plane.
Scene ArcScene(const std::vector<double>& degrees) {
  Scene scene;
  for (size_t i = 0; i < degrees.size(); ++i) {
    const double angle = degrees[i] * M_PI / 180;
    View view;
    view.name = "view" + std::to_string(i);
    view.camera = test::LookAt(5 * Eigen::Vector3d(std::sin(angle), 0, std::cos(angle)),
                               Eigen::Vector3d::Zero(), 100, 100, 100);
    scene.views.push_back(view);
  }
  return scene;
}

TriangleMesh Plane() {
  TriangleMesh mesh;
  test::AppendGrid(&mesh, 8, 0, 0, 0.1, [](double, double) { return 0.0; });
  return mesh;
}

TEST(SparsePointPairs, CountsOnlyPointsInTheParallaxRange) {
  Scene scene = ArcScene({0, 10, 30, 100});
  scene.points = {{Eigen::Vector3d(0.01, 0, 0), {0, 1, 2, 3}},
                  {Eigen::Vector3d(0, 0.01, 0), {0, 2}},
                  {Eigen::Vector3d(0, 0, 0.01), {1, 3}}};
  const std::vector<int> counts = CommonPointCounts(scene, 20 - 1e-6, 60);
  EXPECT_EQ(counts[0 * 4 + 1], 0);  // 10 degrees
  EXPECT_EQ(counts[0 * 4 + 2], 2);  // 30 degrees, two points
  EXPECT_EQ(counts[2 * 4 + 0], 2);
  EXPECT_EQ(counts[1 * 4 + 3], 0);  // 90 degrees
  const auto pairs = SparsePointPairs(scene, 1, 20 - 1, 60);
  ASSERT_EQ(pairs.size(), 3u);
  EXPECT_TRUE((pairs[0] == CameraPair{0, 2}));
  EXPECT_TRUE((pairs[1] == CameraPair{1, 2}));
  EXPECT_TRUE((pairs[2] == CameraPair{2, 0}));
}

TEST(MeshParallaxPairs, SharedAreaIsThatOfThePlaneInRange) {
  const Scene scene = ArcScene({0, 30, 85});
  const std::vector<double> areas = SharedFacetAreas(scene, Plane(), 20, 40);
  // 0.2 x 0.2 seen frontally from 5 at 100 px focal length: 4 x 4 px.
  EXPECT_NEAR(areas[0 * 3 + 1], 16, 0.1);
  EXPECT_NEAR(areas[1 * 3 + 0], 16 * std::cos(30 * M_PI / 180), 0.2);
  EXPECT_EQ(areas[0 * 3 + 2], 0);
}

TEST(MeshParallaxPairs, BackSidesAndHiddenFacetsDoNotCount) {
  Scene scene = ArcScene({0, 30, 180});
  EXPECT_EQ(SharedFacetAreas(scene, Plane(), 0, 180)[0 * 3 + 2], 0);
  TriangleMesh hidden = Plane();  // a lid close in front of the plane
  test::AppendGrid(&hidden, 1, 0, 0, 0.2, [](double, double) { return 0.05; });
  const double open = SharedFacetAreas(scene, Plane(), 20, 40)[1];
  // Only the lid is seen: 0.4 x 0.4, 50/4.95 px per 0.1.
  EXPECT_NEAR(SharedFacetAreas(scene, hidden, 20, 40)[1], open * 4 * std::pow(5 / 4.95, 2), 0.3);
}

TEST(PairSelection, AutoTakesPointsWhenThereAreSome) {
  Scene scene = ArcScene({0, 30});
  EXPECT_EQ(SelectPairs(scene, Plane(), PairsOptions()).method, "mesh_parallax");
  scene.points = {{Eigen::Vector3d::Zero(), {0, 1}}};
  const PairSelection selection = SelectPairs(scene, Plane(), PairsOptions());
  EXPECT_EQ(selection.method, "sparse_points");
  EXPECT_EQ(selection.pairs.size(), 2u);
}

std::string ErrorOf(const Scene& scene, const TriangleMesh& mesh, const PairsOptions& options) {
  try {
    SelectPairs(scene, mesh, options);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(PairSelection, ZeroPairsNamesCameraAndTest) {
  Scene scene = ArcScene({0, 3});
  PairsOptions options;
  EXPECT_EQ(ErrorOf(scene, Plane(), options),
            "no camera pair: view0 shares visible facets with other views, but none under a "
            "parallax of 8-45 deg; view1 shares visible facets with other views, but none under a "
            "parallax of 8-45 deg");
  options.method = "vu";
  EXPECT_EQ(ErrorOf(scene, Plane(), options),
            "pairs.method = vu: the scene has no sparse points; take mesh_parallax");
  scene.points = {{Eigen::Vector3d::Zero(), {0, 1}}};
  EXPECT_NE(ErrorOf(scene, Plane(), options).find("none under a parallax of 20-60 deg"),
            std::string::npos);
}

TEST(PairSelection, ACameraWithoutPartnerIsAWarning) {
  Scene scene = ArcScene({0, 30, 180});
  const PairSelection selection = SelectPairs(scene, Plane(), PairsOptions());
  EXPECT_EQ(selection.pairs.size(), 2u);
  ASSERT_EQ(selection.warnings.size(), 1u);
  EXPECT_NE(selection.warnings[0].find("view2"), std::string::npos);
}

}  // namespace
}  // namespace burin
