#include "core/evaluate/evaluation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/evaluate/evaluation_report.h"
#include "core/mesh/mesh_io.h"
#include "core/support/error.h"
#include "core/support/parallel.h"
#include "tests/test_shapes.h"
#include "tests/test_truths.h"

namespace burin {
namespace {

TEST(Evaluation, ParallelPlanesAreTheirDistanceApart) {
  const double d = 0.03;
  const Truth truths[] = {MeshTruth(Plane(0)), CloudTruth(Plane(0), 40000, true)};
  EvaluationOptions options = Options("0.02,0.04");
  options.max_distance = 0.1;
  for (const Truth& truth : truths) {
    const Evaluation evaluation = EvaluateMesh(Plane(d), truth, options);
    for (const DistanceStatistics& side : {evaluation.accuracy, evaluation.completeness}) {
      EXPECT_NEAR(side.mean, d, 1e-12);
      EXPECT_NEAR(side.median, d, 1e-12);
      EXPECT_NEAR(side.rmse, d, 1e-12);
      EXPECT_EQ(side.matched, side.count);
    }
    ASSERT_EQ(evaluation.scores.size(), 2u);
    EXPECT_EQ(evaluation.scores[0].f1, 0);
    EXPECT_EQ(evaluation.scores[1].precision, 1);
    EXPECT_EQ(evaluation.scores[1].recall, 1);
    EXPECT_EQ(evaluation.scores[1].f1, 1);
  }
}

TEST(Evaluation, SpheresOfTwoRadii) {
  const Evaluation evaluation =
      EvaluateMesh(Sphere(1.02, 5), MeshTruth(Sphere(1.0, 5)), Options("0.01,0.03"));
  // Facets of edge 1/16 sag by about 0.0007.
  EXPECT_NEAR(evaluation.accuracy.mean, 0.02, 5e-4);
  EXPECT_NEAR(evaluation.completeness.rmse, 0.02, 5e-4);
  EXPECT_EQ(evaluation.scores[0].f1, 0);
  EXPECT_EQ(evaluation.scores[1].f1, 1);
  EXPECT_NEAR(evaluation.area, 4 * M_PI * 1.02 * 1.02, 0.02);
}

TEST(Evaluation, HalfAMeshHasFullPrecisionAndHalfRecall) {
  const TriangleMesh half = Grid(8, 1.0, [](double, double) { return 0.0; });
  TriangleMesh left = half;
  for (Eigen::Vector3d& vertex : left.vertices) vertex.x() *= 0.5;
  EvaluationOptions options = Options("0.001");
  const Evaluation evaluation = EvaluateMesh(left, MeshTruth(half), options);
  EXPECT_EQ(evaluation.scores[0].precision, 1);
  EXPECT_NEAR(evaluation.scores[0].recall, 0.501, 2e-3);
  const double recall = evaluation.scores[0].recall;
  EXPECT_NEAR(evaluation.scores[0].f1, 2 * recall / (1 + recall), 1e-12);
  // The other way round, what the truth does not cover counts against precision unless dropped.
  EXPECT_NEAR(EvaluateMesh(half, MeshTruth(left), options).scores[0].precision, 0.501, 2e-3);
  options.unmatched = UnmatchedSamples::kDrop;
  options.max_distance = 0.0011;
  EXPECT_GT(EvaluateMesh(half, MeshTruth(left), options).scores[0].precision, 0.99);
}

TEST(Evaluation, MeshAndCloudTruthAgree) {
  const TriangleMesh truth = Relief(40);
  TriangleMesh mesh = Relief(12);  // coarse: its errors are its facets
  const EvaluationOptions options = Options("0.001,0.003,0.01");
  const Evaluation to_mesh = EvaluateMesh(mesh, MeshTruth(truth), options);
  const Evaluation to_cloud = EvaluateMesh(mesh, CloudTruth(truth, 100000, true), options);
  EXPECT_EQ(to_mesh.distance, DistanceKind::kPoint);
  EXPECT_EQ(to_cloud.distance, DistanceKind::kPlane);
  EXPECT_NEAR(to_cloud.accuracy.mean, to_mesh.accuracy.mean, 0.02 * to_mesh.accuracy.mean);
  EXPECT_NEAR(to_cloud.completeness.mean, to_mesh.completeness.mean,
              0.02 * to_mesh.completeness.mean);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(to_cloud.scores[k].f1, to_mesh.scores[k].f1, 0.01);
  }
  // Without normals the spacing of the points (about 0.003) is a floor.
  const Evaluation to_points = EvaluateMesh(mesh, CloudTruth(truth, 100000, false), options);
  EXPECT_GT(to_points.accuracy.mean, to_mesh.accuracy.mean);
}

TEST(Evaluation, ScoresDoNotDependOnTheTriangulation) {
  const TriangleMesh coarse = Plane(0.01, 1.0, 1);
  TriangleMesh uneven = Plane(0.01, 1.0, 2);
  uneven.vertices[4] = {0.07, 0.04, 0.01};  // the middle vertex, moved within the plane
  Truth truth = MeshTruth(Grid(30, 1.0, [](double x, double) { return 0.04 * x; }));
  const EvaluationOptions options = Options("0.005,0.015", 50000);
  const Evaluation a = EvaluateMesh(coarse, truth, options);
  const Evaluation b = EvaluateMesh(uneven, truth, options);
  EXPECT_NEAR(a.accuracy.mean, b.accuracy.mean, 2e-5);
  EXPECT_NEAR(a.scores[0].precision, b.scores[0].precision, 2e-3);
}

TEST(Evaluation, RigidFitRecoversTheMotion) {
  const TriangleMesh relief = Relief(40);
  Similarity motion;
  motion.rotation =
      Eigen::AngleAxisd(0.01, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  motion.translation = {0.012, -0.008, 0.01};
  const Truth truths[] = {MeshTruth(Moved(relief, motion.Inverse())),
                          CloudTruth(Moved(relief, motion.Inverse()), 100000, true)};
  for (const Truth& truth : truths) {
    EvaluationOptions options = Options("0.002,0.01");
    options.max_distance = 0.1;
    const double unfitted = EvaluateMesh(relief, truth, options).accuracy.mean;
    EXPECT_GT(unfitted, 0.005);
    options.align = AlignmentKind::kRigid;
    const Evaluation evaluation = EvaluateMesh(relief, truth, options);
    const double tolerance = truth.IsMesh() ? 1e-5 : 5e-4;
    const Similarity found = evaluation.truth_from_mesh.Inverse();
    EXPECT_EQ(found.scale, 1);
    const Similarity alone = TruthFromMesh(relief, truth, options);
    EXPECT_EQ(alone.rotation, evaluation.truth_from_mesh.rotation);
    EXPECT_EQ(alone.translation, evaluation.truth_from_mesh.translation);
    EXPECT_TRUE(TruthFromMesh(relief, truth, EvaluationOptions()).translation.isZero(0));
    EXPECT_LT((found.rotation - motion.rotation).norm(), tolerance);
    EXPECT_LT((found.translation - motion.translation).norm(), tolerance);
    EXPECT_NEAR(found.AngleDeg(), 0.01 * 180 / M_PI, 180 / M_PI * tolerance);
    EXPECT_LT(evaluation.accuracy.mean, truth.IsMesh() ? 1e-5 : 2e-4);
    EXPECT_GT(evaluation.scores[0].f1, 0.98);
  }
}

// A mesh three per cent too small, turned and shifted: a rigid fit cannot mend it, a similarity must
// and scores it in the units of the truth.
TEST(Evaluation, SimilarityFitRecoversTheScale) {
  const TriangleMesh relief = Relief(40);
  Similarity motion;
  motion.scale = 1.03;
  motion.rotation =
      Eigen::AngleAxisd(0.015, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  motion.translation = {-0.004, -0.018, 0.01};
  const TriangleMesh mesh = Moved(relief, motion.Inverse());
  EvaluationOptions options = Options("0.002,0.02");
  options.max_distance = 0.2;
  options.align = AlignmentKind::kRigid;
  EXPECT_GT(EvaluateMesh(mesh, MeshTruth(relief), options).accuracy.mean, 1e-3);
  options.align = AlignmentKind::kSimilarity;
  const Evaluation evaluation = EvaluateMesh(mesh, MeshTruth(relief), options);
  EXPECT_TRUE(evaluation.fit_converged);
  EXPECT_NEAR(evaluation.truth_from_mesh.scale, 1.03, 1e-5);
  EXPECT_LT((evaluation.truth_from_mesh.rotation - motion.rotation).norm(), 1e-5);
  EXPECT_LT((evaluation.truth_from_mesh.translation - motion.translation).norm(), 1e-5);
  EXPECT_LT(evaluation.accuracy.mean, 1e-5);
  EXPECT_LT(evaluation.completeness.mean, 1e-5);
  const nlohmann::json json = ToJson(evaluation);
  EXPECT_NEAR(json["alignment"]["scale"].get<double>(), 1.03, 1e-5);
  EXPECT_NEAR(json["alignment"]["truth_from_mesh"][2][2].get<double>(),
              1.03 * motion.rotation(2, 2), 1e-4);
  EXPECT_NE(EvaluationReport(evaluation).find("scale 1.03"), std::string::npos);
}

// Cameras bring near a mesh in another frame and of another size; the surface does the rest.
TEST(Evaluation, FitStartsWhereCamerasPutTheMesh) {
  const TriangleMesh relief = Relief(40);
  Similarity motion;
  motion.scale = 7;
  motion.rotation = Eigen::AngleAxisd(2, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  motion.translation = {30, -5, 12};
  const TriangleMesh mesh = Moved(relief, motion.Inverse());
  EvaluationOptions options = Options("0.002,0.02");
  options.max_distance = 0.2;
  options.align = AlignmentKind::kSimilarity;
  EXPECT_THROW(EvaluateMesh(mesh, MeshTruth(relief), options), InputError);
  options.align = AlignmentKind::kCameras;
  EXPECT_THROW(EvaluateMesh(mesh, MeshTruth(relief), options), InputError);
  Similarity off;  // what wrong cameras leave
  off.scale = 1.01;
  off.translation = {0.004, -0.01, 0.008};
  options.truth_from_scene = off * motion;
  const Evaluation evaluation = EvaluateMesh(mesh, MeshTruth(relief), options);
  EXPECT_NEAR(evaluation.truth_from_mesh.scale, 7, 1e-4);
  EXPECT_LT((evaluation.truth_from_mesh.rotation - motion.rotation).norm(), 1e-5);
  EXPECT_LT((evaluation.truth_from_mesh.translation - motion.translation).norm(), 1e-3);
  EXPECT_LT(evaluation.accuracy.mean, 1e-5);
  EXPECT_EQ(ToJson(evaluation)["alignment"]["kind"], "cameras");
  EXPECT_NE(EvaluationReport(evaluation).find("scale 7"), std::string::npos);
}

// A patch apart from a sphere is 0.05 off in a mesh of 0.8 times the size: the sphere decides the
// fit, and the patch's error is in units of the truth (0.04 in those of the mesh).
TEST(Evaluation, SimilarityScoresInUnitsOfTheTruth) {
  const auto sphere_and_patch = [](double height) {
    TriangleMesh mesh = Sphere(1.0, 4);
    const TriangleMesh patch = Plane(height);
    const int base = static_cast<int>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), patch.vertices.begin(), patch.vertices.end());
    for (const Eigen::Vector3i& face : patch.faces) mesh.faces.push_back(face.array() + base);
    return mesh;
  };
  Similarity shrink;
  shrink.scale = 0.8;
  EvaluationOptions options = Options("0.01,1");
  options.max_distance = 10;
  options.align = AlignmentKind::kSimilarity;
  const Evaluation evaluation =
      EvaluateMesh(Moved(sphere_and_patch(3.05), shrink), MeshTruth(sphere_and_patch(3)), options);
  EXPECT_NEAR(evaluation.truth_from_mesh.scale, 1.25, 1e-5);
  const double patch_share = 1 / (1 + SurfaceArea(Sphere(1.0, 4)));
  EXPECT_NEAR(evaluation.accuracy.mean, 0.05 * patch_share, 1e-5);
  EXPECT_NEAR(evaluation.completeness.mean, 0.05 * patch_share, 1e-5);
}

TEST(Evaluation, BothDistancesAreReported) {
  // Beside its border a plane is near by the plane distance only.
  const TriangleMesh wide = Plane(0.02, 1.2);
  EvaluationOptions options = Options("0.03");
  options.max_distance = 1;
  for (const DistanceKind distance : {DistanceKind::kPoint, DistanceKind::kPlane}) {
    options.distance = distance;
    const Evaluation evaluation = EvaluateMesh(wide, MeshTruth(Plane(0)), options);
    const bool to_plane = evaluation.distance == DistanceKind::kPlane;
    EXPECT_EQ(evaluation.distance, distance);
    ASSERT_EQ(evaluation.other_distance, to_plane ? DistanceKind::kPoint : DistanceKind::kPlane);
    const std::string other = to_plane ? "point" : "plane";
    const DistanceStatistics& plane = to_plane ? evaluation.accuracy : evaluation.other_accuracy;
    const DistanceStatistics& point = to_plane ? evaluation.other_accuracy : evaluation.accuracy;
    EXPECT_NEAR(plane.mean, 0.02, 1e-12);
    EXPECT_GT(point.mean, 0.04);
    EXPECT_EQ(ToJson(evaluation)["other_distance"]["distance"], other);
    EXPECT_NE(EvaluationReport(evaluation).find("accuracy, " + other), std::string::npos);
  }
  options.distance = DistanceKind::kAuto;
  const Evaluation without_normals = EvaluateMesh(wide, CloudTruth(Plane(0), 1000, false), options);
  EXPECT_EQ(without_normals.other_distance, std::nullopt);
  EXPECT_TRUE(ToJson(without_normals)["other_distance"].is_null());
}

TEST(Evaluation, RigidFitLeavesFreeDirectionsAlone) {
  EvaluationOptions options = Options("0.05");
  options.max_distance = 0.5;
  options.align = AlignmentKind::kRigid;
  const Evaluation evaluation = EvaluateMesh(Plane(0.02), MeshTruth(Plane(0)), options);
  EXPECT_NEAR(evaluation.fit_shift, 0.02, 1e-6);
  EXPECT_LT((evaluation.truth_from_mesh.translation + Eigen::Vector3d(0, 0, 0.02)).norm(), 1e-6);
  EXPECT_LT(evaluation.accuracy.mean, 1e-6);
}

TEST(Evaluation, SameBytesForAnyThreadCount) {
  const TriangleMesh mesh = Relief(12);
  const Truth truth = CloudTruth(Relief(30), 20000, true);
  EvaluationOptions options = Options("0.002,0.01");
  options.align = AlignmentKind::kRigid;
  const ThreadScope one_thread(1);
  const std::string one = ToJson(EvaluateMesh(mesh, truth, options)).dump();
  const std::vector<double> errors_one = VertexErrors(mesh, truth);
  const ThreadScope two_threads(2);
  EXPECT_EQ(ToJson(EvaluateMesh(mesh, truth, options)).dump(), one);
  EXPECT_EQ(VertexErrors(mesh, truth), errors_one);
}

TEST(Evaluation, VertexErrorsHaveSigns) {
  const Truth truths[] = {MeshTruth(Plane(0)), CloudTruth(Plane(0), 20000, true)};
  for (const Truth& truth : truths) {
    for (const double z : {0.02, -0.03}) {
      for (const double error : VertexErrors(Plane(z), truth)) EXPECT_NEAR(error, z, 1e-12);
    }
    EXPECT_TRUE(std::isnan(VertexErrors(Plane(0.5), truth, 0.4)[0]));
  }
  EXPECT_GT(VertexErrors(Plane(-0.03), CloudTruth(Plane(0), 20000, false))[0], 0);
}

TEST(Evaluation, RmseToTruthMesh) {
  EXPECT_NEAR(RmseToTruthMesh(Plane(0.03), Plane(0)), 0.03, 1e-12);
  // A ramp from 0 to h over a plane: rmse h / sqrt(3).
  const TriangleMesh ramp = Grid(4, 1.0, [](double x, double) { return 0.1 * x; });
  const double cosine = 1 / std::sqrt(1.01);
  EXPECT_NEAR(RmseToTruthMesh(Plane(0, 1.0), ramp), 0.1 / std::sqrt(3.0) * cosine, 1e-4);
}

TEST(Evaluation, ThresholdsAreParsedStrictly) {
  EvaluationOptions options;
  options.tau = "20,5,10,5";
  EXPECT_EQ(options.Thresholds().size(), 3u);
  EXPECT_DOUBLE_EQ(options.Thresholds()[0], 0.005);
  EXPECT_DOUBLE_EQ(options.Thresholds()[2], 0.02);
  for (const char* text : {"", "5,", ",5", "5 10", "0", "-1", "nan", "inf", "5mm"}) {
    options.tau = text;
    EXPECT_THROW(options.Thresholds(), InputError) << text;
  }
}

TEST(Evaluation, InputErrorsAreSaid) {
  EXPECT_THROW(EvaluateMesh(TriangleMesh(), MeshTruth(Plane(0)), Options("1")), InputError);
  EXPECT_THROW(EvaluateMesh(Plane(0), Truth(), Options("1")), InputError);
  EvaluationOptions options = Options("0.01");
  options.distance = DistanceKind::kPlane;
  EXPECT_THROW(EvaluateMesh(Plane(0), CloudTruth(Plane(0), 100, false), options), InputError);
  options = Options("0.01");
  options.align = AlignmentKind::kRigid;
  EXPECT_THROW(EvaluateMesh(Plane(0), MeshTruth(Plane(100)), options), InputError);
  // Nothing in reach without a fit is a score of zero, not an error.
  options.align = AlignmentKind::kNone;
  const Evaluation evaluation = EvaluateMesh(Plane(0), MeshTruth(Plane(100)), options);
  EXPECT_EQ(evaluation.accuracy.matched, 0);
  EXPECT_EQ(evaluation.scores[0].f1, 0);
  // Its errors are those of no points, not 0.
  EXPECT_TRUE(std::isnan(evaluation.accuracy.rmse));
  EXPECT_TRUE(nlohmann::json::parse(ToJson(evaluation).dump())["accuracy"]["mean"].is_null());
  EXPECT_THAT(EvaluationReport(evaluation),
              testing::ContainsRegex("accuracy .mesh to truth. +- +- +- "));
}

// Converters write zeros where a scan has no normals.
TEST(Evaluation, NormalsOfNoLengthAreNone) {
  Truth truth = CloudTruth(Plane(0), 2000, true);
  const EvaluationOptions options = Options("0.05");
  for (size_t k = 0; k < truth.cloud.normals.size(); k += 10) truth.cloud.normals[k].setZero();
  const Evaluation some = EvaluateMesh(Plane(0.01), truth, options);
  EXPECT_EQ(some.distance, DistanceKind::kPlane);
  EXPECT_EQ(some.zero_normals, 200);
  EXPECT_THAT(EvaluationReport(some), testing::HasSubstr("200 of the truth's 2000 are 0"));
  for (Eigen::Vector3d& normal : truth.cloud.normals) normal.setZero();
  const Evaluation none = EvaluateMesh(Plane(0.01), truth, options);
  EXPECT_EQ(none.distance, DistanceKind::kPoint);
  EXPECT_THAT(EvaluationReport(none), testing::HasSubstr("measured: point distance"));
}

TEST(Evaluation, ReportAndJsonSayTheSame) {
  EvaluationOptions options = Options("20,40", 1000);
  options.unit = 0.001;
  options.max_distance = 123;
  const Evaluation evaluation = EvaluateMesh(Plane(0.03), MeshTruth(Plane(0)), options);
  const std::string report = EvaluationReport(evaluation);
  // What a mean is within stands beside it.
  EXPECT_NE(report.find("         30         30         30        123    100.00         1000"),
            std::string::npos)
      << report;
  EXPECT_NE(report.find("100.00%"), std::string::npos) << report;
  EXPECT_NE(report.find("0.001 world units"), std::string::npos) << report;
  const nlohmann::json json = ToJson(evaluation);
  EXPECT_NEAR(json["accuracy"]["mean"].get<double>(), 0.03, 1e-12);
  EXPECT_EQ(json["scores"][1]["f1"].get<double>(), 1);
  EXPECT_TRUE(json["alignment"].is_null());
  for (const char* side : {"accuracy", "completeness"}) {
    EXPECT_NEAR(json[side]["max_distance"].get<double>(), 0.123, 1e-12) << side;
  }
}

TEST(Evaluation, TruthFilesAreToldApart) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "burin_truth_files";
  std::filesystem::create_directories(folder);
  WriteMesh(folder / "mesh.ply", Plane(0));
  WritePointCloud(folder / "cloud.ply", CloudTruth(Plane(0), 50, true).cloud);
  EXPECT_TRUE(ReadTruth(folder / "mesh.ply").IsMesh());
  const Truth cloud = ReadTruth(folder / "cloud.ply");
  EXPECT_FALSE(cloud.IsMesh());
  EXPECT_EQ(cloud.cloud.normals.size(), 50u);
  EXPECT_THROW(ReadTruth(folder / "missing.ply"), InputError);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace burin
