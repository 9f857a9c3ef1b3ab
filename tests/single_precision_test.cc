// When single precision is seen in photographs, in closed form.
#include "apps/run/single_precision.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/colmap_testing.h"

namespace burin {
namespace {

using testing::HasSubstr;

// A square 2 units wide at `at`, seen by one view 10 units away with a pixel of .01 units.
Scene SceneAt(const Eigen::Vector3d& at) {
  Scene scene;
  View& view = scene.views.emplace_back();
  view.camera.width = view.camera.height = 400;
  view.camera.fx = view.camera.fy = 1000;
  view.camera.cx = view.camera.cy = 200;
  view.camera.rotation.setIdentity();
  view.camera.translation = -at + Eigen::Vector3d(0, 0, 10);
  return scene;
}

TriangleMesh SquareAt(const Eigen::Vector3d& at) {
  TriangleMesh mesh;
  mesh.vertices = {at + Eigen::Vector3d(-1, -1, 0), at + Eigen::Vector3d(1, -1, 0),
                   at + Eigen::Vector3d(1, 1, 0), at + Eigen::Vector3d(-1, 1, 0)};
  mesh.faces = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

TEST(SinglePrecision, StepsAreSaidWhereTheyAreVisible) {
  // A float has 24 bits: from 2^22 to 2^23 its steps are .5, here 50 px.
  const Eigen::Vector3d far(4300000, 0, 0);
  EXPECT_THAT(MeshPrecisionLine(SceneAt(far), SquareAt(far)),
              HasSubstr("steps of 0.5 units, 50 px"));
  EXPECT_EQ(MeshPrecisionLine(SceneAt({0, 0, 0}), SquareAt({0, 0, 0})), "");
  // 2^13 to 2^14: .001 units, a tenth of a pixel.
  EXPECT_EQ(MeshPrecisionLine(SceneAt({8000, 0, 0}), SquareAt({8000, 0, 0})), "");
  // In double precision nothing is lost.
  TriangleMesh mesh = SquareAt(far);
  mesh.vertices[0].x() += 1e-4;
  EXPECT_EQ(MeshPrecisionLine(SceneAt(far), mesh), "");
  EXPECT_THAT(SinglePrecisionSteps(SceneAt(far), mesh.vertices), HasSubstr("50 px"));
}

TEST(SinglePrecision, AStrayPartIsNamed) {
  const Eigen::Vector3d at(4300000, 0, 0);
  TriangleMesh mesh = SquareAt(at);
  EXPECT_EQ(StrayPartLine(SceneAt(at), mesh), "");
  mesh.vertices.insert(mesh.vertices.end(), {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  mesh.faces.emplace_back(4, 5, 6);
  EXPECT_THAT(StrayPartLine(SceneAt(at), mesh),
              HasSubstr("a part at (0, 0, 0) is 4.3e+06 units from what the views see"));
}

}  // namespace
}  // namespace burin
