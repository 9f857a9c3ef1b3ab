// Sheets that a round pushes through each other go as far as they do not cross.
#include "core/refine/crossing_guard.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "apps/run/pipeline.h"
#include "core/support/parallel.h"
#include "core/synthetic/synthetic.h"
#include "core/visibility/mesh_rays.h"
#include "tests/test_scene.h"

namespace burin {
namespace {

struct Surface {
  explicit Surface(TriangleMesh of) : mesh(std::move(of)) {
    context.mesh = &mesh;
    context.faces = VertexFaces(mesh);
    context.neighbors = VertexNeighbors(mesh, context.faces);
    See(false, false);
  }
  Surface(const Surface&) = delete;
  Surface& operator=(const Surface&) = delete;
  // Whether pairs see it, and whether its vertices move where none does.
  void See(bool seen, bool moves) {
    context.seen.assign(mesh.vertices.size(), seen ? 1 : 0);
    context.moves.assign(mesh.vertices.size(), moves ? 1 : 0);
  }
  TriangleMesh mesh;
  RoundContext context;
};

// Two flat sheets, the second at z = 1, that nothing sees. They face each other, or both look up.
struct Sheets : Surface {
  explicit Sheets(bool opposed = true) : Surface(Two(opposed)) {}
  static TriangleMesh Two(bool opposed) {
    TriangleMesh mesh;
    for (const double z : {0.0, 1.0}) {
      test::AppendGrid(&mesh, kCells, 0, 0, 5, [z](double, double) { return z; });
    }
    for (size_t f = mesh.faces.size() / 2; opposed && f < mesh.faces.size(); ++f) {
      std::swap(mesh.faces[f][0], mesh.faces[f][1]);
    }
    return mesh;
  }
  // A dent of this depth in the middle of the upper one.
  void Dent(double depth) {
    for (size_t v = mesh.vertices.size() / 2; v < mesh.vertices.size(); ++v) {
      const Eigen::Vector3d& vertex = mesh.vertices[v];
      mesh.vertices[v].z() -= depth * std::exp(-vertex.head<2>().squaredNorm());
    }
  }
  static constexpr int kCells = 40;
};

// A sheet bent back on itself at x = 0, its halves at z = 0 and 0.2, the edges 1 long.
TriangleMesh Hairpin() {
  constexpr int kHalf = 10;
  TriangleMesh mesh;
  test::AppendGrid(&mesh, 2 * kHalf + 1, 0, 0, kHalf + 0.5, [](double, double) { return 0.0; });
  for (Eigen::Vector3d& vertex : mesh.vertices) {
    vertex.z() = vertex.x() > 0 ? 0.2 : 0;
    vertex.x() = 0.5 - std::abs(vertex.x());
  }
  return mesh;
}

TEST(CrossingGuard, StopsASheetBeforeAnother) {
  for (const bool seen : {false, true}) {
    Sheets sheets;
    sheets.See(seen, seen);
    CrossingGuard guard(sheets.mesh);
    const std::vector<Eigen::Vector3d> before = sheets.mesh.vertices;
    sheets.Dent(1.5);
    const std::vector<Eigen::Vector3d> wanted = sheets.mesh.vertices;
    const CrossingReport report = guard.EndRound(before, sheets.context, true, &sheets.mesh);
    EXPECT_GT(report.found, 20);
    EXPECT_EQ(report.left, 0);
    EXPECT_EQ(guard.Facets(), 0);
    EXPECT_TRUE(CrossingFacets(sheets.mesh).empty());
    int shortened = 0;
    double deepest = 0;
    for (size_t v = 0; v < before.size(); ++v) {
      shortened += sheets.mesh.vertices[v] != wanted[v] ? 1 : 0;
      deepest = std::max(deepest, before[v].z() - sheets.mesh.vertices[v].z());
      if (before[v].head<2>().norm() > 3) {
        EXPECT_EQ(sheets.mesh.vertices[v], wanted[v]);
      }
    }
    EXPECT_EQ(shortened, report.taken_back);
    EXPECT_GT(deepest, 0.5);
    EXPECT_LT(deepest, 1);
  }
}

TEST(CrossingGuard, OnlyLooksWhenToldSo) {
  Sheets sheets;
  CrossingGuard guard(sheets.mesh);
  const std::vector<Eigen::Vector3d> before = sheets.mesh.vertices;
  sheets.Dent(1.5);
  const std::vector<Eigen::Vector3d> wanted = sheets.mesh.vertices;
  const CrossingReport report = guard.EndRound(before, sheets.context, false, &sheets.mesh);
  EXPECT_GT(report.found, 20);
  EXPECT_EQ(report.left, report.found);
  EXPECT_EQ(report.taken_back, 0);
  EXPECT_EQ(sheets.mesh.vertices, wanted);
  EXPECT_EQ(guard.Facets(), CountFacets(CrossingFacets(sheets.mesh)));
}

TEST(CrossingGuard, WhatCrossesAlreadyMayComeBack) {
  Sheets sheets;
  sheets.Dent(1.5);
  CrossingGuard guard(sheets.mesh);
  EXPECT_GT(guard.Facets(), 20);
  const std::vector<Eigen::Vector3d> before = sheets.mesh.vertices;
  sheets.Dent(-1.5);
  const std::vector<Eigen::Vector3d> wanted = sheets.mesh.vertices;
  const CrossingReport report = guard.EndRound(before, sheets.context, true, &sheets.mesh);
  EXPECT_EQ(report.found, 0);
  EXPECT_EQ(sheets.mesh.vertices, wanted);
  EXPECT_EQ(guard.Facets(), 0);
}

TEST(CrossingGuard, DoesTheSameForAnyNumberOfThreads) {
  std::vector<std::vector<Eigen::Vector3d>> results;
  for (const int threads : {1, 3}) {
    const ThreadScope scope(threads);
    Sheets sheets;
    CrossingGuard guard(sheets.mesh);
    const std::vector<Eigen::Vector3d> before = sheets.mesh.vertices;
    sheets.Dent(1.5);
    EXPECT_GT(guard.EndRound(before, sheets.context, true, &sheets.mesh).taken_back, 0);
    results.push_back(sheets.mesh.vertices);
  }
  EXPECT_EQ(results[0], results[1]);
}

// Wrinkles of a doubled surface: no inside comes out.
TEST(CrossingGuard, SheetsThatLookTheSameWayMayCross) {
  Sheets sheets(/*opposed=*/false);
  CrossingGuard guard(sheets.mesh);
  const std::vector<Eigen::Vector3d> before = sheets.mesh.vertices;
  sheets.Dent(1.5);
  const std::vector<Eigen::Vector3d> wanted = sheets.mesh.vertices;
  EXPECT_EQ(guard.EndRound(before, sheets.context, true, &sheets.mesh).found, 0);
  EXPECT_EQ(sheets.mesh.vertices, wanted);
  EXPECT_GT(guard.Facets(), 20);
}

TEST(CrossingGuard, FoldsOfWhatIsSeenAreLeftToThePhotographs) {
  struct Case {
    bool seen;
    bool moves;
    bool counts;
  };
  for (const Case& at : {Case{true, true, false}, {false, true, false}, {false, false, true}}) {
    Surface fold(Hairpin());
    fold.See(at.seen, at.moves);
    CrossingGuard guard(fold.mesh);
    EXPECT_EQ(guard.Facets(), 0);
    const std::vector<Eigen::Vector3d> before = fold.mesh.vertices;
    for (Eigen::Vector3d& vertex : fold.mesh.vertices) {
      if (vertex.z() > 0 && vertex.x() > -1.5) vertex.z() -= 0.3;
    }
    const std::vector<Eigen::Vector3d> wanted = fold.mesh.vertices;
    const CrossingReport report = guard.EndRound(before, fold.context, true, &fold.mesh);
    if (at.counts) {
      EXPECT_GT(report.found, 20);
      EXPECT_EQ(guard.Facets(), 0);
    } else {
      EXPECT_EQ(report.found, 0);
      EXPECT_EQ(fold.mesh.vertices, wanted);
      EXPECT_GT(guard.Facets(), 20);
    }
  }
}

// Of the lines along z through both plates, how many do not meet front, back, front, back.
int WrongLines(const TriangleMesh& mesh, double footprint) {
  const MeshRays rays(mesh);
  int wrong = 0;
  for (double x = -0.75; x < 0.76; x += 0.05) {
    for (double y = -0.55; y < 0.56; y += 0.05) {
      Eigen::Vector3d from(x, y, 1);
      RayHit hit;
      int sides = 0;
      bool in_order = true;
      while (rays.Intersect(from, -Eigen::Vector3d::UnitZ(), &hit)) {
        in_order &= (FaceAreaNormal(mesh, hit.face).z() > 0) == (sides % 2 == 0);
        ++sides;
        from.z() = hit.point.z() - 1e-3 * footprint;
      }
      wrong += in_order && sides == 4 ? 0 : 1;
    }
  }
  return wrong;
}

// Four surfaces a pixel apart, of which the photographs show the outer two. (The rest is carried along.)
TEST(CrossingGuard, TheGapBetweenPlatesSurvives) {
  SyntheticOptions options;
  options.scene = SyntheticKind::kPlates;
  options.width = 320;
  options.height = 240;
  options.samples_per_axis = 2;
  options.gap_px = 1;
  options.pose_noise_px = 1;  // exact cameras cross few of them
  const SyntheticScene plates = MakeSyntheticScene(options);
  EXPECT_EQ(WrongLines(plates.init, plates.footprint), 0);
  PipelineOptions run;
  run.refinement.cameras.refine = CameraUnknowns::kNone;
  run.surface.trim = SurfaceTrim::kNone;
  const PipelineResult result = RunPipeline(plates.scene, plates.init, run);
  EXPECT_EQ(WrongLines(result.mesh, plates.footprint), 0);
  for (const LevelSummary& level : result.refinement.levels) EXPECT_GT(level.TakenBack(), 0);

  run.refinement.guard.crossings = Crossings::kReport;
  const PipelineResult crossed = RunPipeline(plates.scene, plates.init, run);
  EXPECT_GT(WrongLines(crossed.mesh, plates.footprint), 20);
  const LevelSummary& level = crossed.refinement.levels.back();
  EXPECT_EQ(level.crossing_facets.after, CountFacets(CrossingFacets(crossed.mesh)));
  EXPECT_GT(level.crossing_facets.after, 3 * result.refinement.levels.back().crossing_facets.after);
}

}  // namespace
}  // namespace burin
