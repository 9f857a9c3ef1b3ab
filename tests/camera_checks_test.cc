// Degenerate cameras are named.
#include "core/scene/formats/camera_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "core/support/error.h"

namespace burin {
namespace {

using testing::HasSubstr;

std::vector<View> TwoViews() {
  std::vector<View> views(2);
  for (int v = 0; v < 2; ++v) {
    views[v].name = v == 0 ? "a.png" : "b.png";
    Camera& camera = views[v].camera;
    camera.width = 6;
    camera.height = 4;
    camera.fx = camera.fy = 5;
    camera.translation.x() = v;
  }
  return views;
}

std::string ErrorOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

std::string ErrorWith(const std::function<void(Camera*)>& change) {
  std::vector<View> views = TwoViews();
  change(&views[1].camera);
  return ErrorOf([&] {
    CheckCameras(views, "file");
    CheckCentresDiffer(views, "file");
  });
}

TEST(CameraChecks, NameWhatIsWrong) {
  EXPECT_EQ(ErrorWith([](Camera* /*camera*/) {}), "no error");
  EXPECT_THAT(ErrorWith([](Camera* c) { c->fx = 0; }), HasSubstr("file: b.png: focal length = 0"));
  EXPECT_THAT(ErrorWith([](Camera* c) { c->fy = std::numeric_limits<double>::quiet_NaN(); }),
              HasSubstr("b.png: focal length"));
  EXPECT_THAT(ErrorWith([](Camera* c) { c->height = 0; }), HasSubstr("b.png: image size = 6 x 0"));
  EXPECT_THAT(ErrorWith([](Camera* c) { c->cx = std::numeric_limits<double>::infinity(); }),
              HasSubstr("principal point"));
  EXPECT_THAT(ErrorWith([](Camera* c) { c->rotation(0, 0) = 1.1; }), HasSubstr("rotation"));
  EXPECT_THAT(ErrorWith([](Camera* c) { c->rotation = -c->rotation; }), HasSubstr("rotation"));
  // In millimetres, as a share of the width, of a picture of another size.
  const auto with_focal = [](double focal) {
    return ErrorWith([focal](Camera* c) {
      c->width = 320;
      c->height = 240;
      c->fx = c->fy = focal;
    });
  };
  EXPECT_THAT(with_focal(24), HasSubstr("b.png: focal length = 24 pixels of a picture 320x240: no "
                                        "camera's; must be in [32, 16000]"));
  EXPECT_THAT(with_focal(0.94), HasSubstr("focal length = 0.94"));
  EXPECT_THAT(with_focal(16001), HasSubstr("focal length = 16001"));
  EXPECT_EQ(with_focal(32), "no error");     // 157 degrees
  EXPECT_EQ(with_focal(16000), "no error");  // a telescope's 1.1 degrees
  // Finite, but beyond what single precision holds.
  EXPECT_THAT(ErrorWith([](Camera* c) { c->fx = 1e-12; }), HasSubstr("focal length = 1e-12"));
  EXPECT_THAT(ErrorWith([](Camera* c) { c->fy = 1e302; }), HasSubstr("focal length = 1e+302"));
  EXPECT_THAT(ErrorWith([](Camera* c) { c->cy = -1e30; }), HasSubstr("principal point = -1e+30"));
  EXPECT_THAT(ErrorWith([](Camera* c) { c->translation.y() = 1e19; }),
              HasSubstr("translation = 1e+19: must be within 1e+17"));
  EXPECT_THAT(ErrorWith([](Camera* c) { c->translation.setZero(); }),
              HasSubstr("file: all 2 cameras have the same centre"));
}

TEST(CameraChecks, SameCentreWhateverTheRotationAndFarFromTheOrigin) {
  std::vector<View> views = TwoViews();
  const Eigen::Vector3d center(1e6, -2e6, 3e5);
  for (int v = 0; v < 2; ++v) {
    Camera& camera = views[v].camera;
    camera.rotation = Eigen::AngleAxisd(0.7 * v, Eigen::Vector3d(1, 2, 3).normalized()).matrix();
    camera.translation = -camera.rotation * center;
  }
  EXPECT_THAT(ErrorOf([&] { CheckCentresDiffer(views, "file"); }), HasSubstr("same centre"));
  views[1].camera.translation.x() += 1e-3;
  EXPECT_EQ(ErrorOf([&] { CheckCentresDiffer(views, "file"); }), "no error");
}

TEST(CameraChecks, RoundedTakesTheLastBitsAway) {
  Camera camera = TwoViews()[1].camera;
  camera.cx = 1520.69 + 0.5;
  camera.rotation = Eigen::AngleAxisd(2.9, Eigen::Vector3d(1, -2, 3).normalized()).matrix();
  camera.translation = {-7.28137, 1e-5, 0.204446};
  Camera other = camera;
  other.cx = 1521.19;
  other.rotation = Eigen::Quaterniond(camera.rotation).normalized().toRotationMatrix();
  other.translation = -other.rotation * camera.Center();
  const Camera a = Rounded(camera);
  const Camera b = Rounded(other);
  EXPECT_EQ(a.cx, b.cx);
  EXPECT_EQ(a.rotation, b.rotation);
  EXPECT_EQ(a.translation, b.translation);
  EXPECT_LT((a.ProjectionMatrix() - camera.ProjectionMatrix()).norm(),
            1e-10 * camera.ProjectionMatrix().norm());
  EXPECT_EQ(Rounded(a).rotation, a.rotation);
}

TEST(CameraChecks, ARotationOfFewDigitsBecomesOne) {
  const Eigen::Matrix3d exact =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).matrix();
  const Eigen::Matrix3d rounded = (exact * 1e4).array().round() / 1e4;
  const Eigen::Matrix3d mended = NearestRotation(rounded, "file", "line 3: R");
  EXPECT_LT((mended * mended.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-14);
  EXPECT_LT((mended - exact).norm(), 2e-4);
  EXPECT_THAT(ErrorOf([&] { NearestRotation(2 * exact, "file", "line 3: R"); }),
              HasSubstr("file: line 3: R: is not a rotation"));
  EXPECT_THAT(ErrorOf([&] { NearestRotation(-exact, "file", "line 3: R"); }), HasSubstr("mirrors"));
}

}  // namespace
}  // namespace burin
