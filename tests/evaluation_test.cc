#include "core/evaluation.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>

#include "core/closest_point.h"
#include "core/error.h"
#include "core/evaluation_report.h"
#include "core/mesh_io.h"
#include "core/parallel.h"
#include "core/surface_samples.h"

namespace burin {
namespace {

// n x n squares over [0, size]^2 at the height given by `height`, facing +z.
template <typename Height>
TriangleMesh Grid(int n, double size, const Height& height) {
  TriangleMesh mesh;
  for (int r = 0; r <= n; ++r) {
    for (int c = 0; c <= n; ++c) {
      const double x = size * c / n;
      const double y = size * r / n;
      mesh.vertices.emplace_back(x, y, height(x, y));
    }
  }
  for (int r = 0; r < n; ++r) {
    for (int c = 0; c < n; ++c) {
      const int a = r * (n + 1) + c;
      mesh.faces.emplace_back(a, a + 1, a + n + 2);
      mesh.faces.emplace_back(a, a + n + 2, a + n + 1);
    }
  }
  return mesh;
}

TriangleMesh Plane(double z, double size = 1.0, int n = 8) {
  return Grid(n, size, [&](double, double) { return z; });
}

TriangleMesh Relief(int n) {
  return Grid(n, 1.0, [](double x, double y) {
    return 0.2 * std::sin(5 * x + 1) * std::cos(4 * y) + 0.1 * x * x;
  });
}

// Octahedron split `levels` times onto the sphere, outward.
TriangleMesh Sphere(double radius, int levels) {
  TriangleMesh mesh;
  mesh.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.faces = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int level = 0; level < levels; ++level) {
    TriangleMesh finer;
    finer.vertices = mesh.vertices;
    for (const Eigen::Vector3i& f : mesh.faces) {
      const int a = static_cast<int>(finer.vertices.size());
      for (int c = 0; c < 3; ++c) {
        finer.vertices.push_back(
            (mesh.vertices[f[c]] + mesh.vertices[f[(c + 1) % 3]]).normalized());
      }
      finer.faces.emplace_back(f[0], a, a + 2);
      finer.faces.emplace_back(f[1], a + 1, a);
      finer.faces.emplace_back(f[2], a + 2, a + 1);
      finer.faces.emplace_back(a, a + 1, a + 2);
    }
    mesh = finer;
  }
  for (Eigen::Vector3d& vertex : mesh.vertices) vertex *= radius;
  return mesh;
}

Truth MeshTruth(const TriangleMesh& mesh) {
  Truth truth;
  truth.mesh = mesh;
  return truth;
}

Truth CloudTruth(const TriangleMesh& mesh, int count, bool normals) {
  const SurfaceSamples samples = SampleSurface(mesh, count, 99);
  Truth truth;
  truth.cloud.points = samples.points;
  if (normals) truth.cloud.normals = samples.normals;
  return truth;
}

EvaluationOptions Options(const std::string& tau, int samples = 20000) {
  EvaluationOptions options;
  options.tau = tau;
  options.unit = 1;
  options.sample_count = samples;
  return options;
}

TEST(SurfaceSamples, AreUniformOverTheArea) {
  // One face has 1/9 of the area of the other: shares follow the area, not the face count.
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 0, 0}, {8, 0, 0}, {5, 3, 0}};
  mesh.faces = {{0, 1, 2}, {1, 1, 2}, {3, 4, 5}};
  const int count = 10000;
  const SurfaceSamples samples = SampleSurface(mesh, count);
  ASSERT_EQ(samples.points.size(), size_t{count});
  EXPECT_NEAR(std::count(samples.faces.begin(), samples.faces.end(), 0), count / 10, 1);
  EXPECT_EQ(std::count(samples.faces.begin(), samples.faces.end(), 1), 0);

  // Within a face: every cell of a 10 x 10 grid over a plane gets its share.
  const SurfaceSamples plane = SampleSurface(Plane(0, 1.0, 3), 100000, 5);
  int in_cell[10][10] = {};
  for (const Eigen::Vector3d& point : plane.points) {
    ASSERT_TRUE(point.x() >= 0 && point.x() <= 1 && point.y() >= 0 && point.y() <= 1);
    ++in_cell[std::min(9, static_cast<int>(point.x() * 10))]
             [std::min(9, static_cast<int>(point.y() * 10))];
  }
  for (const auto& row : in_cell) {
    for (const int n : row) EXPECT_NEAR(n, 1000, 30);  // random points: standard deviation 31
  }
}

TEST(SurfaceSamples, SameSeedSamePoints) {
  const SurfaceSamples first = SampleSurface(Relief(10), 1000, 3);
  EXPECT_EQ(first.points, SampleSurface(Relief(10), 1000, 3).points);
  EXPECT_NE(first.points, SampleSurface(Relief(10), 1000, 4).points);
  EXPECT_TRUE(SampleSurface(TriangleMesh(), 10).points.empty());
}

TEST(MeshDistance, AgreesWithBruteForceAndGivesSides) {
  const TriangleMesh sphere = Sphere(1.0, 2);
  const MeshDistance distance(sphere);
  const SurfaceSamples queries = SampleSurface(Sphere(1.7, 1), 300);
  for (int k = 0; k < 300; ++k) {
    const Eigen::Vector3d query = queries.points[k] * (k % 3 == 0 ? 0.3 : 1.0);
    double nearest = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3i& f : sphere.faces) {  // dense points on each face
      for (int i = 0; i <= 40; ++i) {
        for (int j = 0; j <= 40 - i; ++j) {
          const Eigen::Vector3d point = (i * sphere.vertices[f[0]] + j * sphere.vertices[f[1]] +
                                         (40 - i - j) * sphere.vertices[f[2]]) /
                                        40;
          nearest = std::min(nearest, (point - query).norm());
        }
      }
    }
    const SurfacePoint found = distance.Find(query);
    ASSERT_GE(found.face, 0);
    EXPECT_LE(found.distance, nearest + 1e-12);
    EXPECT_NEAR(found.distance, nearest, 2e-3);
    EXPECT_NEAR((query - found.point).norm(), found.distance, 1e-12);
    EXPECT_EQ(found.SignedDistance(query) > 0, k % 3 != 0);
  }
}

TEST(MeshDistance, CornersEdgesAndDegenerateFaces) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {5, 5, 5}};
  mesh.faces = {{0, 1, 2}, {3, 3, 3}, {3, 3, 0}};
  const MeshDistance distance(mesh);
  EXPECT_DOUBLE_EQ(distance.Find({-3, -4, 0}).distance, 5);
  EXPECT_DOUBLE_EQ(distance.Find({0.5, 0.5, -2}).distance, 2);
  EXPECT_DOUBLE_EQ(distance.Find({2, 2, 0}).distance, std::sqrt(2.0));
  EXPECT_DOUBLE_EQ(distance.Find({6, 5, 5}).distance, 1);
  EXPECT_EQ(distance.Find({6, 5, 5}, 0.5).face, -1);
  EXPECT_EQ(distance.Find({0.5, 0.5, -2}, 2.0).face, 0);
  EXPECT_EQ(distance.Find({0, 0, std::nan("")}).face, -1);
  EXPECT_EQ(MeshDistance(TriangleMesh()).Find({0, 0, 0}).face, -1);
}

TEST(MeshDistance, KeepsItsDigitsFarFromTheOrigin) {
  const Eigen::Vector3d far(4.0e5, 5.0e6, 300);
  TriangleMesh mesh = Plane(0);
  for (Eigen::Vector3d& vertex : mesh.vertices) vertex += far;
  const MeshDistance distance(mesh);
  EXPECT_NEAR(distance.Find(far + Eigen::Vector3d(0.3, 0.4, 0.001)).distance, 0.001, 1e-9);
}

TEST(CloudDistance, FindsTheNearest) {
  const SurfaceSamples samples = SampleSurface(Sphere(1.0, 2), 2000);
  const CloudDistance cloud(samples.points);
  for (int k = 0; k < 200; ++k) {
    const Eigen::Vector3d query = samples.points[k] * 1.3 + Eigen::Vector3d(0.05, -0.1, 0.02);
    double nearest = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3d& p : samples.points) nearest = std::min(nearest, (p - query).norm());
    double found = 0;
    const int index = cloud.Find(query, 10, &found);
    ASSERT_GE(index, 0);
    EXPECT_DOUBLE_EQ(found, nearest);
    EXPECT_DOUBLE_EQ((samples.points[index] - query).norm(), nearest);
    EXPECT_EQ(cloud.Find(query, 0.999 * nearest), -1);
  }
}

TEST(Evaluation, ParallelPlanesAreTheirDistanceApart) {
  const double d = 0.03;
  const Truth truths[] = {MeshTruth(Plane(0)), CloudTruth(Plane(0), 40000, true)};
  for (const Truth& truth : truths) {
    const Evaluation evaluation = EvaluateMesh(Plane(d), truth, Options("0.02,0.04"));
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
  options.unmatched = "drop";
  options.max_distance = 0.0011;
  EXPECT_GT(EvaluateMesh(half, MeshTruth(left), options).scores[0].precision, 0.99);
}

TEST(Evaluation, MeshAndCloudTruthAgree) {
  const TriangleMesh truth = Relief(40);
  TriangleMesh mesh = Relief(12);  // coarse: its errors are its facets
  const EvaluationOptions options = Options("0.001,0.003,0.01");
  const Evaluation to_mesh = EvaluateMesh(mesh, MeshTruth(truth), options);
  const Evaluation to_cloud = EvaluateMesh(mesh, CloudTruth(truth, 100000, true), options);
  EXPECT_EQ(to_mesh.distance, "point");
  EXPECT_EQ(to_cloud.distance, "plane");
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
  RigidMotion motion;
  motion.rotation =
      Eigen::AngleAxisd(0.01, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  motion.translation = {0.012, -0.008, 0.01};
  const Truth truths[] = {MeshTruth(Moved(relief, motion.Inverse())),
                          CloudTruth(Moved(relief, motion.Inverse()), 100000, true)};
  for (const Truth& truth : truths) {
    EvaluationOptions options = Options("0.002,0.01");
    const double unfitted = EvaluateMesh(relief, truth, options).accuracy.mean;
    EXPECT_GT(unfitted, 0.005);
    options.rigid = true;
    const Evaluation evaluation = EvaluateMesh(relief, truth, options);
    const double tolerance = truth.IsMesh() ? 1e-5 : 5e-4;
    EXPECT_LT((evaluation.mesh_from_truth.rotation - motion.rotation).norm(), tolerance);
    EXPECT_LT((evaluation.mesh_from_truth.translation - motion.translation).norm(), tolerance);
    EXPECT_NEAR(evaluation.fit_angle_deg, 0.01 * 180 / M_PI, 180 / M_PI * tolerance);
    EXPECT_LT(evaluation.accuracy.mean, truth.IsMesh() ? 1e-5 : 2e-4);
    EXPECT_GT(evaluation.scores[0].f1, 0.98);
  }
}

TEST(Evaluation, RigidFitLeavesFreeDirectionsAlone) {
  EvaluationOptions options = Options("0.05");
  options.rigid = true;
  const Evaluation evaluation = EvaluateMesh(Plane(0.02), MeshTruth(Plane(0)), options);
  EXPECT_NEAR(evaluation.fit_shift, 0.02, 1e-6);
  EXPECT_LT((evaluation.mesh_from_truth.translation - Eigen::Vector3d(0, 0, 0.02)).norm(), 1e-6);
  EXPECT_LT(evaluation.accuracy.mean, 1e-6);
}

TEST(Evaluation, SameBytesForAnyThreadCount) {
  const TriangleMesh mesh = Relief(12);
  const Truth truth = CloudTruth(Relief(30), 20000, true);
  EvaluationOptions options = Options("0.002,0.01");
  options.rigid = true;
  SetThreadCount(1);
  const std::string one = ToJson(EvaluateMesh(mesh, truth, options)).dump();
  const std::vector<double> errors_one = VertexErrors(mesh, truth);
  SetThreadCount(2);
  EXPECT_EQ(ToJson(EvaluateMesh(mesh, truth, options)).dump(), one);
  EXPECT_EQ(VertexErrors(mesh, truth), errors_one);
  SetThreadCount(0);
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
  options.distance = "plane";
  EXPECT_THROW(EvaluateMesh(Plane(0), CloudTruth(Plane(0), 100, false), options), InputError);
  options = Options("0.01");
  options.rigid = true;
  EXPECT_THROW(EvaluateMesh(Plane(0), MeshTruth(Plane(100)), options), InputError);
  // Nothing in reach without a fit is a score of zero, not an error.
  options.rigid = false;
  const Evaluation evaluation = EvaluateMesh(Plane(0), MeshTruth(Plane(100)), options);
  EXPECT_EQ(evaluation.accuracy.matched, 0);
  EXPECT_EQ(evaluation.scores[0].f1, 0);
}

TEST(Evaluation, ReportAndJsonSayTheSame) {
  EvaluationOptions options = Options("20,40", 1000);
  options.unit = 0.001;
  const Evaluation evaluation = EvaluateMesh(Plane(0.03), MeshTruth(Plane(0)), options);
  const std::string report = EvaluationReport(evaluation);
  EXPECT_NE(report.find("100.00%"), std::string::npos) << report;
  EXPECT_NE(report.find("0.001 world units"), std::string::npos) << report;
  const nlohmann::json json = ToJson(evaluation);
  EXPECT_NEAR(json["accuracy"]["mean"].get<double>(), 0.03, 1e-12);
  EXPECT_EQ(json["scores"][1]["f1"].get<double>(), 1);
  EXPECT_TRUE(json["rigid_fit"].is_null());
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

// The scores that this mesh is published with: the protocol is the one they were measured by.
TEST(Evaluation, ReproducesTheFountainsPublishedScores) {
  const char* data = std::getenv("BURIN_SHARED_DATA");
  const std::filesystem::path folder = std::filesystem::path(data ? data : "") / "fountain-p11";
  if (data == nullptr || !std::filesystem::exists(folder / "truth/points_10mm.ply")) {
    GTEST_SKIP() << "BURIN_SHARED_DATA does not hold fountain-p11";
  }
  EvaluationOptions options;
  options.rigid = true;
  options.sample_count = 200000;
  options.unmatched = "drop";
  const Evaluation evaluation = EvaluateMesh(ReadMesh(folder / "init.ply"),
                                             ReadTruth(folder / "truth/points_10mm.ply"), options);
  EXPECT_NEAR(evaluation.accuracy.median, 0.0077, 0.0001);
  EXPECT_NEAR(evaluation.accuracy.mean, 0.0216, 0.0002);
  const double precision[] = {0.38, 0.57, 0.71};
  const double f1[] = {0.31, 0.48, 0.60};
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(evaluation.scores[k].precision, precision[k], 0.0075);
    EXPECT_NEAR(evaluation.scores[k].f1, f1[k], 0.0075);
  }
}

}  // namespace
}  // namespace burin
