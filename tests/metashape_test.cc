// cameras.xml gives the cameras that it was made of, by the formulas of Metashape's manual.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <iomanip>
#include <sstream>
#include <string>

#include "core/scene/lens_points.h"
#include "tests/given_scene.h"

namespace burin {
namespace {

using testing::HasSubstr;

class Metashape : public GivenScene {
 protected:
  // In a chunk that is turned, scaled and moved into the world.
  std::string Given(const std::string& reference = "LOCAL_CS[\"Local\"]",
                    const std::string& more = "") const {
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized()).matrix();
    const Eigen::Vector3d move(3, -2, 1);
    const double scale = 2.5;
    std::ostringstream xml;
    xml << std::setprecision(17) << "<?xml version=\"1.0\"?>\n<document><chunk><sensors>\n";
    for (int v = 0; v < 2; ++v) {
      const Camera& c = CameraAt(v);
      xml << "<sensor id=\"" << v << "\" type=\"frame\"><resolution width=\"6\" height=\"4\"/>"
          << "<calibration class=\"initial\"><f>1</f></calibration><calibration class=\"adjusted\">"
          << "<resolution width=\"6\" height=\"4\"/><f>" << c.fy << "</f><b1>" << c.fx - c.fy
          << "</b1><cx>" << c.cx - 3 << "</cx><cy>" << c.cy - 2 << "</cy>" << more
          << "</calibration></sensor>\n";
    }
    xml << "</sensors><components><component id=\"0\"><transform><rotation locked=\"1\">";
    for (int k = 0; k < 9; ++k) xml << turn(k / 3, k % 3) << " ";
    xml << "</rotation><translation>" << move.transpose() << "</translation><scale>" << scale
        << "</scale></transform></component></components><cameras><group>\n";
    for (int v = 0; v < 2; ++v) {
      const Camera& c = CameraAt(v);
      Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
      m.topLeftCorner<3, 3>() = turn.transpose() * c.rotation.transpose();
      m.topRightCorner<3, 1>() = turn.transpose() * (c.Center() - move) / scale;
      xml << "<camera id=\"" << v << "\" sensor_id=\"" << v << "\" component_id=\"0\" label=\"view"
          << v << "\"><transform>";
      for (int k = 0; k < 16; ++k) xml << m(k / 4, k % 4) << " ";
      xml << "</transform></camera>\n";
    }
    xml << "</group><camera id=\"7\" sensor_id=\"0\" label=\"lost\"/></cameras><reference>"
        << reference << "</reference></chunk></document>";
    return xml.str();
  }
  std::string ErrorOf(std::string xml, const std::string& from, const std::string& to) const {
    WriteFile("cameras.xml", xml.replace(xml.find(from), from.size(), to));
    return LoadError(Folder());
  }
};

TEST_F(Metashape, CamerasInTheWorld) {
  WriteFile("cameras.xml", Given());
  EXPECT_EQ(FormatOf(Folder()), "Metashape");
  const Scene scene = LoadScene({Folder(), {}, {}});
  ExpectScene(scene, false);
  EXPECT_THAT(scene.notes,
              testing::ElementsAre(HasSubstr("1 of 3 cameras left out: they are not aligned "
                                             "or disabled; the first is lost")));
  ExpectScene(LoadScene({Folder() / "cameras.xml", Images(), {}}), false);
}

TEST_F(Metashape, GeoreferencedScenesStayInTheChunk) {
  WriteFile("cameras.xml", Given("GEOGCS[\"WGS 84\"]"));
  const Scene scene = LoadScene({Folder(), {}, {}});
  ASSERT_EQ(scene.notes.size(), 2U);
  EXPECT_THAT(scene.notes[1], HasSubstr("cameras are georeferenced"));
  EXPECT_NEAR((scene.views[0].camera.Center() - scene.views[1].camera.Center()).norm(),
              (CameraAt(0).Center() - CameraAt(1).Center()).norm() / 2.5, 1e-9);
}

TEST_F(Metashape, LensByTheManual) {
  WriteFile("cameras.xml",
            Given("", "<k1>.1</k1><k2>-.2</k2><k3>.05</k3><p1>.003</p1><p2>-.004</p2>"));
  const PosedImage image = ReadScene({Folder(), {}, {}}).images[0];
  const double x = 0.3;
  const double y = -0.2;
  const double r2 = x * x + y * y;
  const double radial = 1 + 0.1 * r2 - 0.2 * r2 * r2 + 0.05 * r2 * r2 * r2;
  const double u = x * radial + 0.003 * (r2 + 2 * x * x) - 2 * 0.004 * x * y;
  const double v = y * radial - 0.004 * (r2 + 2 * y * y) + 2 * 0.003 * x * y;
  const Camera& c = image.camera;
  const Eigen::Vector2d at = PhotographedAt(c, image.lens, {c.cx + c.fx * x, c.cy + c.fy * y});
  EXPECT_NEAR(at.x(), c.cx + c.fx * u, 1e-9);
  EXPECT_NEAR(at.y(), c.cy + c.fy * v, 1e-9);
}

TEST_F(Metashape, WhatIsWrongIsNamed) {
  const std::string good = Given("", "<b2>0</b2>");
  EXPECT_THAT(ErrorOf(good, "<b2>0<", "<b2>0.3<"),
              HasSubstr("camera view0: b2 = 0.3 is not supported"));
  EXPECT_THAT(ErrorOf(good, "type=\"frame\"", "type=\"fisheye\""),
              HasSubstr("camera view0: sensor of type 'fisheye' is not supported"));
  EXPECT_THAT(ErrorOf(good, "sensor_id=\"1\"", "sensor_id=\"8\""),
              HasSubstr("camera view1: its sensor is missing"));
  EXPECT_THAT(ErrorOf(good, "<scale>2.5", "<scale>-1"),
              HasSubstr("component 0: scale: must be above 0"));
  EXPECT_THAT(ErrorOf(good, "<scale>2.5", "<scale>2,5"), HasSubstr("scale: '2,5' is not a number"));
  EXPECT_THAT(ErrorOf(good, "label=\"view1\"", "label=\"none\""),
              HasSubstr("photograph none: is in none of"));
  EXPECT_THAT(ErrorOf(good, "</document>", ""), HasSubstr("not valid XML"));
  EXPECT_THAT(ErrorOf(good, "<chunk>", "<part>"), HasSubstr("not valid XML"));
  WriteFile("cameras.xml", "<other/>");
  EXPECT_THAT(LoadError(Folder()), HasSubstr("document/chunk: is missing"));
}

}  // namespace
}  // namespace burin
