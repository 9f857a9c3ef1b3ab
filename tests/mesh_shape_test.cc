#include "core/evaluate/mesh_shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/evaluate/evaluation.h"
#include "core/evaluate/evaluation_report.h"
#include "tests/test_shapes.h"
#include "tests/test_truths.h"

namespace burin {
namespace {

TriangleMesh Triangle(const Eigen::Vector3d& apex) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, apex};
  mesh.faces = {{0, 1, 2}};
  return mesh;
}

TriangleMesh Turned(TriangleMesh mesh) {
  for (Eigen::Vector3i& face : mesh.faces) std::swap(face[0], face[1]);
  return mesh;
}

TEST(MeshShape, ClosedForms) {
  const MeshShape even = ShapeOf(Triangle({0.5, std::sqrt(0.75), 0}));
  EXPECT_NEAR(even.quality, 1, 1e-12);
  EXPECT_EQ(even.under_10_deg, 0);
  EXPECT_EQ(even.over_150_deg, 0);
  // Right-angled and isosceles: 4 sqrt(3) / 2 / (1 + 1 + 2).
  EXPECT_NEAR(ShapeOf(Triangle({0, 1, 0})).quality, std::sqrt(3.0) / 2, 1e-12);
  const double degree = std::acos(-1.0) / 180;
  for (const double angle : {9.9, 10.1}) {
    const MeshShape needle = ShapeOf(Triangle({0, std::tan(angle * degree), 0}));
    EXPECT_EQ(needle.under_10_deg, angle < 10 ? 1 : 0);
    EXPECT_EQ(needle.over_150_deg, 0);
  }
  for (const double half : {14.9, 15.1}) {  // the apex has 180 degrees less twice this
    const MeshShape cap = ShapeOf(Triangle({0.5, 0.5 * std::tan(half * degree), 0}));
    EXPECT_EQ(cap.over_150_deg, half < 15 ? 1 : 0);
  }
  const MeshShape nothing = ShapeOf(Triangle({0.5, 0, 0}));
  EXPECT_EQ(nothing.quality, 0);
  EXPECT_EQ(nothing.under_10_deg, 1);
  EXPECT_EQ(nothing.over_150_deg, 1);
  EXPECT_EQ(ShapeOf(TriangleMesh()).quality, 0);
}

TEST(MeshShape, TurnedSurfaceIsSeenWhereDistancesSeeNothing) {
  const EvaluationOptions options = Options("0.02");
  for (const Truth& truth : {MeshTruth(Plane(0)), CloudTruth(Plane(0), 40000, true)}) {
    const Evaluation right = EvaluateMesh(Plane(0), truth, options);
    const Evaluation turned = EvaluateMesh(Turned(Plane(0)), truth, options);
    EXPECT_EQ(right.scores[0].f1, turned.scores[0].f1);
    EXPECT_EQ(right.turned.value(), 0);
    EXPECT_EQ(turned.turned.value(), 1);
    const TriangleMesh plane = Plane(0);
    TriangleMesh both = Turned(plane);
    const auto count = static_cast<int>(plane.vertices.size());
    both.vertices.insert(both.vertices.end(), plane.vertices.begin(), plane.vertices.end());
    for (const Eigen::Vector3i& face : plane.faces) both.faces.emplace_back(face.array() + count);
    EXPECT_NEAR(EvaluateMesh(both, truth, options).turned.value(), 0.5, 0.05);
  }
  EXPECT_FALSE(
      EvaluateMesh(Plane(0), CloudTruth(Plane(0), 40000, false), options).turned.has_value());
}

TEST(MeshShape, ReportAndJsonSayTheSame) {
  const Evaluation evaluation =
      EvaluateMesh(Turned(Plane(0)), MeshTruth(Plane(0)), Options("0.02"));
  const std::string report = EvaluationReport(evaluation);
  EXPECT_NE(report.find("facets: mean quality 0.866, 0.00 % with an angle under 10 degrees"),
            std::string::npos)
      << report;
  EXPECT_NE(report.find("turned: 100.00 % of the matched area"), std::string::npos) << report;
  EXPECT_NE(report.find("area: 1.000 of the truth's"), std::string::npos) << report;
  const nlohmann::json json = ToJson(evaluation);
  EXPECT_EQ(json["turned"], 1);
  EXPECT_NEAR(json["mesh"]["quality"].get<double>(), std::sqrt(0.75), 1e-12);
  EXPECT_EQ(json["truth_area"], json["mesh"]["area"]);
  const nlohmann::json cloud =
      ToJson(EvaluateMesh(Plane(0), CloudTruth(Plane(0), 40000, false), Options("0.02")));
  EXPECT_TRUE(cloud["turned"].is_null());
  EXPECT_TRUE(cloud["truth_area"].is_null());
}

}  // namespace
}  // namespace burin
