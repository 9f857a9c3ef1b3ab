// The guard: it keeps a refinement from making a mesh worse.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "apps/run/pipeline.h"
#include "core/evaluate/evaluation.h"
#include "core/refine/level_judge.h"
#include "core/refine/local_guard.h"
#include "core/synthetic/synthetic.h"
#include "tests/small_relief.h"
#include "tests/split_facets.h"
#include "tests/test_scene.h"
#include "tests/test_shapes.h"

namespace burin {
namespace {

const SyntheticScene& Relief() {
  static const auto* scene = new SyntheticScene(MakeSyntheticScene(test::SmallReliefOptions(7)));
  return *scene;
}

struct Sheet {
  Sheet() {
    test::AppendGrid(&mesh, 20, 0, 0, 10, [](double, double) { return 0.0; });  // edges of 1
    faces = VertexFaces(mesh);
    neighbors = VertexNeighbors(mesh, faces);
    before = mesh.vertices;
  }
  LocalGuardReport Guard(const GuardOptions& options = {}) {
    return RevertFaults(before, faces, neighbors, 1.0, options, &mesh);
  }
  TriangleMesh mesh;
  Adjacency faces;
  Adjacency neighbors;
  std::vector<Eigen::Vector3d> before;
};

constexpr int kMiddle = 10 * 21 + 10;

TEST(LocalGuard, LeavesAGoodRoundAlone) {
  Sheet sheet;
  for (Eigen::Vector3d& v : sheet.mesh.vertices) v.z() += 3 + 0.5 * std::sin(v.x());
  const std::vector<Eigen::Vector3d> moved = sheet.mesh.vertices;
  EXPECT_EQ(sheet.Guard().reverted_vertices, 0);
  EXPECT_EQ(sheet.mesh.vertices, moved);
}

TEST(LocalGuard, ASpikeContinuesItsNeighboursDisplacement) {
  Sheet sheet;
  for (Eigen::Vector3d& v : sheet.mesh.vertices) v.z() += 2 + 0.1 * v.x();
  const std::vector<Eigen::Vector3d> good = sheet.mesh.vertices;
  sheet.mesh.vertices[kMiddle].z() += 12;
  const LocalGuardReport report = sheet.Guard();
  EXPECT_EQ(report.stretched_edges, 6);
  EXPECT_EQ(report.inverted_facets, 0);
  EXPECT_EQ(report.far_vertices, 0);
  EXPECT_GT(report.reverted_vertices, 0);
  for (size_t v = 0; v < good.size(); ++v) {
    EXPECT_LT((sheet.mesh.vertices[v] - good[v]).norm(), 0.05) << v;
  }
}

TEST(LocalGuard, FarAndInvertedVerticesAreTakenBack) {
  Sheet sheet;
  GuardOptions options;
  options.max_stretch = 0;
  sheet.mesh.vertices[kMiddle].z() = 31;
  EXPECT_EQ(sheet.Guard(options).far_vertices, 1);
  EXPECT_LT(std::abs(sheet.mesh.vertices[kMiddle].z()), 1e-9);
  sheet.mesh.vertices = sheet.before;
  sheet.mesh.vertices[kMiddle].x() += 1.5;  // past its neighbour, in the plane
  const LocalGuardReport report = sheet.Guard();
  EXPECT_GT(report.inverted_facets, 0);
  EXPECT_EQ(sheet.Guard().inverted_facets, 0);
  options.max_move_px = 0;
  options.inverted = false;
  sheet.mesh.vertices[kMiddle] = Eigen::Vector3d(50, 3, 1e4);
  EXPECT_EQ(sheet.Guard(options).reverted_vertices, 0);
}

TEST(LocalGuard, WhereNothingCanStayAllStandsWhereItStood) {
  Sheet sheet;
  for (Eigen::Vector3d& v : sheet.mesh.vertices) v.x() = -v.x();  // every facet turned over
  const LocalGuardReport report = sheet.Guard();
  EXPECT_EQ(report.reverted_vertices, static_cast<int>(sheet.before.size()));
  for (size_t v = 0; v < sheet.before.size(); ++v) {
    EXPECT_LT((sheet.mesh.vertices[v] - sheet.before[v]).norm(), 1e-12);
  }
}

TEST(Guard, AnUndoneLevelLeavesTheSurfaceOfItsStart) {
  PipelineOptions options;
  options.refinement.level.count = 2;
  options.refinement.guard.levels = false;
  class SaysNo : public LevelJudge {
   public:
    const std::vector<CameraPair>& HeldBackPairs() const override { return pairs_; }
    void BeginLevel(const RoundContext& first, const TermRounds& /*terms*/, LevelFacets /*facets*/,
                    const nlohmann::json& /*report*/) override {
      before_ = *first.mesh;
    }
    LevelVerdict EndLevel(const RoundContext& last, const TermRounds& /*terms*/,
                          const TriangleMesh& after) override {
      EXPECT_EQ(before_.faces, after.faces);
      EXPECT_NE(before_.vertices, after.vertices);
      EXPECT_EQ((*last.held_back)[2].seconds, std::vector<int>{5});
      EXPECT_GT((*last.held_back)[2].pair_pixels[0], 1000);
      return {std::vector<char>(after.vertices.size(), 1), "no"};
    }

   private:
    const std::vector<CameraPair> pairs_ = {{2, 5}};
    TriangleMesh before_;
  };
  SaysNo judge;
  PipelineParts parts;
  parts.judge = &judge;
  const PipelineResult result = RunPipeline(Relief().scene, Relief().init, options, parts);
  ASSERT_EQ(result.refinement.levels.size(), 2U);
  for (const LevelSummary& level : result.refinement.levels) {
    EXPECT_TRUE(level.undone);
    EXPECT_EQ(level.held_back, "no");
  }
  EXPECT_GT(result.mesh.faces.size(), Relief().init.faces.size());
  EXPECT_LT(RmseToTruthMesh(result.mesh, Relief().init, 20000), 1e-9 * Relief().footprint);
}

// Whatever it is shown.
class Says : public LevelJudge {
 public:
  explicit Says(bool worse) : worse_(worse) {}
  const std::vector<CameraPair>& HeldBackPairs() const override { return pairs_; }
  void BeginLevel(const RoundContext& /*first*/, const TermRounds& /*terms*/,
                  LevelFacets /*facets*/, const nlohmann::json& /*report*/) override {}
  LevelVerdict EndLevel(const RoundContext& last, const TermRounds& /*terms*/,
                        const TriangleMesh& after) override {
    EXPECT_NE(last.held_back, nullptr);
    return {std::vector<char>(after.vertices.size(), worse_ ? 1 : 0), "said"};
  }

 private:
  const bool worse_;
  const std::vector<CameraPair> pairs_ = {{2, 5}};
};

// As far as the next level can tell, an undone one never was: what nothing but it has seen does not count
// as seen.
TEST(Guard, AnUndoneLevelLeavesTheStateOfItsStart) {
  PipelineOptions options;
  options.refinement.level.count = 2;
  options.refinement.guard.levels = false;
  Says judge(/*worse=*/true);
  PipelineParts parts;
  parts.judge = &judge;
  int levels = 0;
  parts.observers.on_state = [&](const RefinementState& state) {
    const auto seen = std::count(state.was_supported.begin(), state.was_supported.end(), 1);
    if (state.round > 0) {
      EXPECT_GT(seen, 100);
      return;
    }
    ++levels;
    EXPECT_EQ(seen, 0);
    EXPECT_EQ(state.was_supported.size(), state.mesh.vertices.size());
    EXPECT_EQ(state.mesh.vertices, state.level_start.vertices);
  };
  RunPipeline(Relief().scene, Relief().init, options, parts);
  EXPECT_EQ(levels, 1);
}

// In its first round, in one that no level ends with, and in its last.
TEST(Guard, ALevelThatTheRunIsStoppedInIsJudged) {
  for (int round = 0; round < 3; ++round) {
    for (const bool worse : {false, true}) {
      SCOPED_TRACE(std::to_string(round) + (worse ? " worse" : " not worse"));
      PipelineOptions options = test::SplitFacets();
      options.refinement.level.count = 1;
      options.refinement.level.rounds = 3;
      options.refinement.guard.levels = false;
      Says judge(worse);
      PipelineParts parts;
      parts.judge = &judge;
      parts.observers.on_iteration = [&](const RefinementEvent& event) {
        return event.round < round || event.iteration.iteration < 1;
      };
      const PipelineResult result = RunPipeline(Relief().scene, Relief().init, options, parts);
      ASSERT_EQ(result.refinement.levels.size(), 1U);
      const LevelSummary& level = result.refinement.levels[0];
      EXPECT_EQ(static_cast<int>(level.rounds.size()), round + 1);
      EXPECT_TRUE(level.interrupted);
      EXPECT_EQ(level.held_back, "said");
      EXPECT_EQ(level.undone, worse);
      const double moved = RmseToTruthMesh(result.mesh, Relief().init, 20000);
      if (worse) {
        EXPECT_LT(moved, 1e-9 * Relief().footprint);
      } else {
        EXPECT_GT(moved, 0.1 * Relief().footprint);
      }
    }
  }
}

// On a level that is not the last, too.
TEST(Guard, AMeshThatTheRunIsStoppedAtHasItsInvertedFacetsChecked) {
  for (const bool stopped : {false, true}) {
    PipelineOptions options;
    options.refinement.level.count = 2;
    options.refinement.level.rounds = 2;
    options.refinement.level.extra_rounds = 0;
    options.refinement.guard.max_stretch = 0;
    options.refinement.guard.max_move_px = 0;
    PipelineParts parts;
    parts.observers.on_iteration = [&](const RefinementEvent& event) {
      return !stopped || event.iteration.iteration < 1;
    };
    parts.solve_round = [](const FrozenRound& round) {
      RoundTrial trial = round.solve("lm_pcg", {});
      const Eigen::Vector3i& face =
          round.context->mesh->faces[round.context->mesh->faces.size() / 2];
      trial.vertices[face[0]] += 1.6 * (trial.vertices[face[1]] - trial.vertices[face[0]]);
      return trial;
    };
    const PipelineResult result = RunPipeline(Relief().scene, Relief().init, options, parts);
    const LevelSummary& level = result.refinement.levels[0];
    EXPECT_EQ(level.rounds.size(), stopped ? 1U : 2U);
    EXPECT_EQ(level.interrupted, stopped);
    EXPECT_GT(level.rounds[0].guard.inverted_facets, 0);
    EXPECT_EQ(level.rounds[0].guard.reverted_vertices > 0, stopped);
  }
}

// The part of a mesh whose facets are made of vertices beyond `z`.
TriangleMesh Behind(const TriangleMesh& mesh, double z) {
  TriangleMesh part;
  part.vertices = mesh.vertices;
  for (const Eigen::Vector3i& face : mesh.faces) {
    if (mesh.vertices[face[0]].z() < z) part.faces.push_back(face);
  }
  return part;
}

TEST(WeakEvidence, ASphereThatNobodySeesStaysThatSphere) {
  const SyntheticScene& scene = Relief();
  TriangleMesh sphere = Sphere(0.3, 2);
  for (Eigen::Vector3d& v : sphere.vertices) v += Eigen::Vector3d(0.1, 0, -1);
  TriangleMesh mesh = scene.init;
  const auto first = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), sphere.vertices.begin(), sphere.vertices.end());
  for (const Eigen::Vector3i& face : sphere.faces) {
    mesh.faces.push_back(face + Eigen::Vector3i::Constant(first));
  }
  const PipelineResult result = RunPipeline(scene.scene, mesh, test::SplitFacets());
  for (size_t v = 0; v < sphere.vertices.size(); ++v) {
    EXPECT_LT((result.mesh.vertices[first + v] - sphere.vertices[v]).norm(), 1e-6 * 0.3);
  }
  EXPECT_LT(RmseToTruthMesh(Behind(result.mesh, -0.6), sphere, 5000), 1e-6 * 0.3);
  EXPECT_LT(RmseToTruthMesh(Behind(sphere, -0.6), Behind(result.mesh, -0.6), 5000), 1e-6 * 0.3);
}

// A closed slab around the plane x = 0, `cells` facets along its sides of length 2.
TriangleMesh Slab(int cells, double thickness) {
  TriangleMesh mesh;
  for (const double side : {1.0, -1.0}) {
    const auto base = static_cast<int>(mesh.vertices.size());
    for (int i = 0; i <= cells; ++i) {
      for (int j = 0; j <= cells; ++j) {
        mesh.vertices.emplace_back(side * thickness / 2, 2.0 * i / cells - 1, 2.0 * j / cells - 1);
      }
    }
    for (int i = 0; i < cells; ++i) {
      for (int j = 0; j < cells; ++j) {
        const int a = base + i * (cells + 1) + j;
        const int b = a + 1;
        const int c = a + cells + 1;
        if (side > 0) {
          mesh.faces.emplace_back(a, c, c + 1);
          mesh.faces.emplace_back(a, c + 1, b);
        } else {
          mesh.faces.emplace_back(a, c + 1, c);
          mesh.faces.emplace_back(a, b, c + 1);
        }
      }
    }
  }
  // The rim: front and back boundary vertices, counter-clockwise seen from +x.
  std::vector<int> loop;
  loop.reserve(4 * static_cast<size_t>(cells));
  for (int i = 0; i < cells; ++i) loop.push_back(i * (cells + 1));
  for (int j = 0; j < cells; ++j) loop.push_back(cells * (cells + 1) + j);
  for (int i = cells; i > 0; --i) loop.push_back(i * (cells + 1) + cells);
  for (int j = cells; j > 0; --j) loop.push_back(j);
  const int back = (cells + 1) * (cells + 1);
  for (size_t k = 0; k < loop.size(); ++k) {
    const int a = loop[k];
    const int b = loop[(k + 1) % loop.size()];
    mesh.faces.emplace_back(a, a + back, b + back);
    mesh.faces.emplace_back(a, b + back, b);
  }
  return mesh;
}

TEST(WeakEvidence, TwoSheetsThreePixelsApartStayApart) {
  SyntheticOptions options;
  options.scene = SyntheticKind::kScan;
  options.scan_up = SignedAxis::kY;
  options.views = 12;
  options.width = 240;
  options.height = 180;
  options.samples_per_axis = 2;
  options.truth_point_count = 1000;
  options.point_count = 500;
  // The scene scales its mesh to the unit sphere: thickness in units of half the diagonal, sqrt(2).
  const double footprint = MakeSyntheticScene(options, Slab(4, 0.1)).footprint;
  const double thickness = 3 * footprint;
  const SyntheticScene scene = MakeSyntheticScene(options, Slab(100, thickness * std::sqrt(2.0)));
  TriangleMesh init = Slab(8, thickness * std::sqrt(2.0));
  test::Random noise(3);
  for (Eigen::Vector3d& v : init.vertices) {
    v /= std::sqrt(2.0);
    v.x() += 0.7 * footprint * noise.Uniform();
  }
  const double before = RmseToTruthMesh(init, scene.truth, 20000);
  const PipelineResult result = RunPipeline(scene.scene, init, PipelineOptions());
  const double after = RmseToTruthMesh(result.mesh, scene.truth, 20000);
  RecordProperty("before_px", std::to_string(before / footprint));
  RecordProperty("after_px", std::to_string(after / footprint));
  EXPECT_LT(after, before);
  // Nothing of a sheet has come to the other's side. The rim, between them, is a pixel wide.
  const double inside = 1 / std::sqrt(2.0) - footprint;
  int crossed = 0;
  for (const Eigen::Vector3i& face : result.mesh.faces) {
    const Eigen::Vector3d normal =
        (result.mesh.vertices[face[1]] - result.mesh.vertices[face[0]])
            .cross(result.mesh.vertices[face[2]] - result.mesh.vertices[face[0]])
            .normalized();
    const Eigen::Vector3d middle = (result.mesh.vertices[face[0]] + result.mesh.vertices[face[1]] +
                                    result.mesh.vertices[face[2]]) /
                                   3;
    if (std::max(std::abs(middle.y()), std::abs(middle.z())) > inside) continue;
    if (std::abs(normal.x()) > 0.9 && normal.x() * middle.x() < 0) ++crossed;
  }
  EXPECT_EQ(crossed, 0);
}

double RmsSd(const PipelineResult& result) {
  double squared = 0;
  int count = 0;
  EXPECT_EQ(result.quality[3].name, "sd_px");
  for (const float sd : result.quality[3].values) {
    if (!std::isfinite(sd)) continue;
    squared += sd * sd;
    ++count;
  }
  return std::sqrt(squared / count);
}

// A refinement of the truth itself ends at the noise floor: the standard deviation that noise gives
// the vertices of a mesh as fine as a refinement makes it (costs/vertex_quality.h), which smoothness
// lowers.
TEST(WeakEvidence, AnExactMeshStaysWithinTheNoiseFloor) {
  const SyntheticScene& scene = Relief();
  const PipelineResult coarse = RunPipeline(scene.scene, scene.init, PipelineOptions());
  const double floor = RmsSd(coarse);
  const double reached = RmseToTruthMesh(coarse.mesh, scene.truth, 20000) / scene.footprint;
  // What the vertices claim is what they have, to a factor of two.
  EXPECT_GT(reached, 0.5 * floor);
  EXPECT_LT(reached, 2 * floor);
  const PipelineResult exact = RunPipeline(scene.scene, scene.truth, PipelineOptions());
  const double after = RmseToTruthMesh(exact.mesh, scene.truth, 20000) / scene.footprint;
  RecordProperty("floor_px", std::to_string(floor));
  RecordProperty("reached_px", std::to_string(reached));
  RecordProperty("after_px", std::to_string(after));
  EXPECT_LT(after, floor);
  EXPECT_LT(after, reached);
}

}  // namespace
}  // namespace burin
