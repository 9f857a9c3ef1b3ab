// The DTU protocol on points and surfaces with known distances, and its files.
#include "core/evaluate/dtu_evaluation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/evaluate/evaluation_report.h"
#include "core/mesh/point_thinning.h"
#include "core/mesh/surface_samples.h"
#include "core/support/error.h"
#include "tests/test_scene.h"
#include "tests/test_shapes.h"

namespace burin {
namespace {

using testing::HasSubstr;

Truth MeshTruth(const TriangleMesh& mesh) {
  Truth truth;
  truth.mesh = mesh;
  return truth;
}

DtuOptions Options(double spacing, double cap) {
  DtuOptions options;
  options.run = true;
  options.spacing = spacing;
  options.cap = cap;
  return options;
}

// n points 0, 1, ..., n - 1 along x, at height z.
std::vector<Eigen::Vector3d> Row(int n, double z) {
  std::vector<Eigen::Vector3d> points;
  points.reserve(n);
  for (int k = 0; k < n; ++k) points.emplace_back(k, 0, z);
  return points;
}

TEST(Thinned, KeepsTheSpacingAndLeavesNoGap) {
  test::Random random(5);
  std::vector<Eigen::Vector3d> points;
  points.reserve(3000);
  for (int k = 0; k < 3000; ++k) {
    points.emplace_back(random.Uniform(), random.Uniform(), 0.1 * random.Uniform());
  }
  const double spacing = 0.1;
  const std::vector<Eigen::Vector3d> thinned = Thinned(points, spacing, 1);
  EXPECT_LT(thinned.size(), points.size() / 3);
  for (size_t a = 0; a < thinned.size(); ++a) {
    for (size_t b = 0; b < a; ++b) EXPECT_GE((thinned[a] - thinned[b]).norm(), spacing);
  }
  for (const Eigen::Vector3d& point : points) {
    double nearest = 1;
    for (const Eigen::Vector3d& kept : thinned) nearest = std::min(nearest, (kept - point).norm());
    EXPECT_LT(nearest, spacing);
  }
}

TEST(Thinned, LeavesSparsePointsAndDropsRepeats) {
  std::vector<Eigen::Vector3d> points = Row(20, 0);
  EXPECT_EQ(Thinned(points, 1.0, 0), points);
  EXPECT_LE(Thinned(points, 1.01, 0).size(), 10u);
  points.insert(points.end(), points.begin(), points.end());
  EXPECT_EQ(Thinned(points, 1.0, 0).size(), 20u);
}

TEST(Dtu, ParallelPlanesAreTheirDistanceApart) {
  const double d = 0.03;
  const DtuEvaluation evaluation =
      EvaluateDtu(Plane(d), MeshTruth(Plane(0)), Options(0.01, 1), {}, 1, 0);
  // The same samples on both, thinned alike: every point has its counterpart straight across.
  for (const DistanceStatistics& side : {evaluation.accuracy, evaluation.completeness}) {
    EXPECT_NEAR(side.mean, d, 1e-12);
    EXPECT_NEAR(side.median, d, 1e-12);
    EXPECT_EQ(side.matched, side.count);
  }
  EXPECT_NEAR(*evaluation.Overall(), d, 1e-12);
  EXPECT_EQ(evaluation.mesh_points, evaluation.truth_points);
  // Randomly placed discs jam at 0.70 per square of the spacing; four candidates come near it.
  EXPECT_GT(evaluation.mesh_points, 5000);
  EXPECT_LT(evaluation.mesh_points, 7000);
}

TEST(Dtu, SpheresOfTwoRadii) {
  // Points of one lie within the spacing h of those straight across: d <= distance and
  // distance <= sqrt(d^2 + h^2), about d + h^2 / 2d = d + 0.0016.
  const DtuEvaluation evaluation =
      EvaluateDtu(Sphere(1.1, 4), MeshTruth(Sphere(1.0, 4)), Options(0.018, 1), {}, 1, 0);
  EXPECT_NEAR(evaluation.accuracy.mean, 0.1, 2e-3);
  EXPECT_NEAR(evaluation.completeness.mean, 0.1, 2e-3);
}

TEST(Dtu, LengthsScaleWithTheUnit) {
  const DtuEvaluation evaluation =
      EvaluateDtu(Plane(0.03), MeshTruth(Plane(0)), Options(20, 1000), {}, 0.001, 0);
  EXPECT_NEAR(evaluation.spacing, 0.02, 1e-15);
  EXPECT_NEAR(evaluation.cap, 1.0, 1e-15);
  EXPECT_NEAR(evaluation.accuracy.mean, 0.03, 1e-12);
}

TEST(Dtu, PointsBeyondTheCapAreLeftOut) {
  std::vector<Eigen::Vector3d> mesh = Row(10, 0.5);
  mesh.emplace_back(0, 0, 30);  // an outlier
  const std::vector<Eigen::Vector3d> truth = Row(10, 0);
  const DtuEvaluation capped = CompareDtuPoints(mesh, truth, 20);
  EXPECT_EQ(capped.accuracy.count, 11);
  EXPECT_EQ(capped.accuracy.matched, 10);
  EXPECT_DOUBLE_EQ(capped.accuracy.mean, 0.5);
  EXPECT_DOUBLE_EQ(capped.completeness.mean, 0.5);
  const DtuEvaluation wide = CompareDtuPoints(mesh, truth, 31);
  EXPECT_EQ(wide.accuracy.matched, 11);
  EXPECT_NEAR(wide.accuracy.mean, (10 * 0.5 + 30) / 11, 1e-12);
  EXPECT_DOUBLE_EQ(wide.accuracy.median, 0.5);
  const DtuEvaluation none = CompareDtuPoints(mesh, truth, 0.1);
  EXPECT_EQ(none.accuracy.matched, 0);
  EXPECT_FALSE(none.Overall().has_value());
  EXPECT_TRUE(ToJson(none)["overall"].is_null());
}

TEST(Dtu, MaskLeavesOutPointsOfTheMeshOnly) {
  // Errors 1 at x = 0..4 and 2 at x = 5..9; voxels of edge 1 around x = 0..4.
  std::vector<Eigen::Vector3d> mesh = Row(10, 1);
  for (int k = 5; k < 10; ++k) mesh[k].z() = 2;
  DtuRegion region;
  region.mask.emplace();
  region.mask->origin = {0, 0, 1};
  region.mask->cell_size = 1;
  region.mask->dimensions = {5, 1, 2};
  region.mask->voxels = std::string(10, '\1');
  const DtuEvaluation evaluation = CompareDtuPoints(mesh, Row(10, 0), 20, region);
  EXPECT_EQ(evaluation.mesh_points, 10);
  EXPECT_EQ(evaluation.accuracy.count, 5);
  EXPECT_DOUBLE_EQ(evaluation.accuracy.mean, 1);
  // The masked points still cover the truth: those at x = 5..9 are 2 away, or sqrt(1 + k^2) from
  // the last one at height 1, whatever is less.
  EXPECT_EQ(evaluation.completeness.count, 10);
  EXPECT_NEAR(evaluation.completeness.mean, (5 * 1 + std::sqrt(2.0) + 4 * 2) / 10, 1e-12);

  region.mask->voxels[2] = 0;  // voxel (2, 0, 0)
  EXPECT_EQ(CompareDtuPoints(mesh, Row(10, 0), 20, region).accuracy.count, 4);
  region.mask->voxels[5 + 3] = 0;  // (3, 0, 1) at height 2, where no point of x < 5 is
  EXPECT_EQ(CompareDtuPoints(mesh, Row(10, 0), 20, region).accuracy.count, 4);
  region.mask->voxels.assign(10, '\0');
  EXPECT_THROW(CompareDtuPoints(mesh, Row(10, 0), 20, region), InputError);
}

TEST(Dtu, PlaneLeavesOutPointsOfTheTruthOnly) {
  const std::vector<Eigen::Vector3d> mesh = Row(10, 1);
  std::vector<Eigen::Vector3d> truth = Row(10, 0);
  for (int k = 0; k < 3; ++k) truth[k].z() = -4;
  DtuRegion region;
  region.plane = Eigen::Vector4d(0, 0, 1, 2);  // z > -2
  const DtuEvaluation evaluation = CompareDtuPoints(mesh, truth, 20, region);
  EXPECT_EQ(evaluation.truth_points, 10);
  EXPECT_EQ(evaluation.completeness.count, 7);
  EXPECT_DOUBLE_EQ(evaluation.completeness.mean, 1);
  EXPECT_EQ(evaluation.accuracy.count, 10);
  region.plane = Eigen::Vector4d(0, 0, 1, 0);  // points on the plane are not above it
  EXPECT_THROW(CompareDtuPoints(mesh, truth, 20, region), InputError);
}

TEST(VoxelMask, ContainsRoundsToTheNearestCentre) {
  VoxelMask mask;
  mask.origin = {10, 20, 30};
  mask.cell_size = 0.5;
  mask.dimensions = {2, 3, 4};
  mask.voxels = std::string(24, '\0');
  mask.voxels[1 + 2 * (2 + 3 * 3)] = 7;  // (1, 2, 3)
  const Eigen::Vector3d centre(10.5, 21, 31.5);
  EXPECT_TRUE(mask.Contains(centre));
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_TRUE(mask.Contains(centre + 0.24 * Eigen::Vector3d::Unit(axis)));
    EXPECT_FALSE(mask.Contains(centre + 0.26 * Eigen::Vector3d::Unit(axis)));
    EXPECT_TRUE(mask.Contains(centre - 0.24 * Eigen::Vector3d::Unit(axis)));
    EXPECT_FALSE(mask.Contains(centre - 0.26 * Eigen::Vector3d::Unit(axis)));
  }
  EXPECT_FALSE(mask.Contains({1e300, 0, 0}));
}

class RegionFilesTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (std::filesystem::path(testing::TempDir()) / "region XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path Write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }
  // The message names the file and holds `part`.
  template <typename Read>
  void ExpectRefused(const Read& read, const std::string& text, const std::string& part) const {
    try {
      read(Write("file", text));
      ADD_FAILURE() << text << " was read";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(folder_.string()));
      EXPECT_THAT(error.what(), HasSubstr(part));
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
  }
  std::filesystem::path folder_;
};

TEST_F(RegionFilesTest, MaskReadsBackAndFaultsAreNamed) {
  Write("a.raw", std::string("\0\1\0\0\0\1", 6));
  const auto header = [](const std::string& origin, const std::string& size,
                         const std::string& dimensions, const std::string& voxels) {
    return "{\"origin\": " + origin + ", \"cell_size\": " + size +
           ", \"dimensions\": " + dimensions + ", \"voxels\": " + voxels + "}";
  };
  const VoxelMask mask =
      ReadVoxelMask(Write("a.json", header("[1, 2.5, -3]", "0.5", "[3, 2, 1]", "\"a.raw\"")));
  EXPECT_EQ(mask.origin, Eigen::Vector3d(1, 2.5, -3));
  EXPECT_EQ(mask.cell_size, 0.5);
  EXPECT_EQ(mask.dimensions, Eigen::Vector3i(3, 2, 1));
  EXPECT_TRUE(mask.Contains({1.5, 2.5, -3}));
  EXPECT_TRUE(mask.Contains({2, 3, -3}));
  EXPECT_FALSE(mask.Contains({1, 2.5, -3}));

  const std::string o = "[0, 0, 0]";
  const std::string d = "[3, 2, 1]";
  const std::string v = "\"a.raw\"";
  ExpectRefused(ReadVoxelMask, "{", "not valid JSON");
  ExpectRefused(ReadVoxelMask, "[]", "must be {");
  ExpectRefused(ReadVoxelMask, "{}", "origin: ");
  ExpectRefused(ReadVoxelMask, header("[0, 0]", "1", d, v), "origin: ");
  ExpectRefused(ReadVoxelMask, header("[0, 0, \"0\"]", "1", d, v), "origin: ");
  ExpectRefused(ReadVoxelMask, header("[0, 0, 1e999]", "1", d, v), "too large");
  ExpectRefused(ReadVoxelMask, header(o, "0", d, v), "cell_size: ");
  ExpectRefused(ReadVoxelMask, header(o, "1", "[3, 2]", v), "dimensions: ");
  ExpectRefused(ReadVoxelMask, header(o, "1", "[3, 2, 0]", v), "dimensions: ");
  ExpectRefused(ReadVoxelMask, header(o, "1", "[3, 2, -1]", v), "dimensions: ");
  ExpectRefused(ReadVoxelMask, header(o, "1", "[3, 2, 1.5]", v), "dimensions: ");
  ExpectRefused(ReadVoxelMask, header(o, "1", "[3, 2, 1000001]", v), "dimensions: ");
  ExpectRefused(ReadVoxelMask, header(o, "1", d, "3"), "voxels: ");
  ExpectRefused(ReadVoxelMask, header(o, "1", d, "\"none.raw\""), "none.raw: file is missing");
  ExpectRefused(ReadVoxelMask, header(o, "1", "[3, 2, 2]", v), "a.raw: has 6 bytes");
  ExpectRefused(ReadVoxelMask, "{\"cellsize\": 1}", "cellsize: unknown");
}

TEST_F(RegionFilesTest, PlaneReadsBackAndFaultsAreNamed) {
  EXPECT_EQ(ReadPlane(Write("p.txt", "0 -0.5\n1e2\t3\n")), Eigen::Vector4d(0, -0.5, 100, 3));
  ExpectRefused(ReadPlane, "0 0 1", "3 numbers");
  ExpectRefused(ReadPlane, "0 0 1 2 3", "more than four");
  ExpectRefused(ReadPlane, "0 0 one 2", "number 3 of a b c d is 'one'");
  ExpectRefused(ReadPlane, "0 0 nan 2", "number 3");
  ExpectRefused(ReadPlane, "0 0 0 2", "all zero");
}

TEST(Dtu, ContradictionsAreRefused) {
  DtuOptions options;
  options.mask = "mask.json";
  EXPECT_THROW(ReadDtuRegion(options), InputError);  // without run
  EXPECT_THROW(EvaluateDtu(TriangleMesh(), MeshTruth(Plane(0)), Options(0.1, 1), {}, 1, 0),
               InputError);
  EXPECT_THROW(EvaluateDtu(Plane(0), Truth(), Options(0.1, 1), {}, 1, 0), InputError);
  // 4e8 samples; coordinates of 1e9 spacings.
  EXPECT_THROW(EvaluateDtu(Plane(0), MeshTruth(Plane(0)), Options(1e-4, 1), {}, 1, 0), InputError);
  Truth far;
  far.cloud.points = {{2e9, 0, 0}};
  EXPECT_THROW(EvaluateDtu(Plane(0), far, Options(0.5, 1), {}, 1, 0), InputError);
}

TEST(Dtu, ReportAndJsonSayTheSame) {
  const DtuEvaluation evaluation =
      EvaluateDtu(Plane(0.03), MeshTruth(Plane(0)), Options(20, 1000), {}, 0.001, 0);
  const std::string report = DtuReport(evaluation, 0.001);
  EXPECT_THAT(report, HasSubstr("20 apart"));
  EXPECT_THAT(report, HasSubstr("further than 1000"));
  EXPECT_THAT(report, HasSubstr("        30         30"));
  const nlohmann::json json = ToJson(evaluation);
  EXPECT_NEAR(json["accuracy"]["median"].get<double>(), 0.03, 1e-12);
  EXPECT_NEAR(json["overall"].get<double>(), 0.03, 1e-12);
  EXPECT_EQ(json["mesh_points"].get<std::int64_t>(), evaluation.mesh_points);
}

}  // namespace
}  // namespace burin
