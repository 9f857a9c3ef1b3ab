// What a run says at its end, and the parts of a mesh that take none in it.
#include "apps/run/closing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "apps/run/mesh_parts.h"
#include "apps/run/pipeline.h"
#include "apps/run/run_output.h"
#include "core/evaluate/evaluation.h"
#include "core/support/error.h"
#include "core/synthetic/synthetic.h"
#include "tests/small_relief.h"

namespace burin {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

ClosingFigures Figures(double before, double after, double standard_error, int batches = 64) {
  ClosingFigures figures;
  figures.held_back = HeldBackVerdict{before, after, standard_error, 1000, batches};
  return figures;
}

TEST(Closing, FirstWordIsTheChangeInStandardErrors) {
  EXPECT_EQ(OutcomeOf(Figures(0.4, 0.3, 0.01)), RunOutcome::kWorked);
  EXPECT_EQ(OutcomeOf(Figures(0.4, 0.39, 0.01)), RunOutcome::kLittle);
  EXPECT_EQ(OutcomeOf(Figures(0.4, 0.41, 0.01)), RunOutcome::kLittle);
  EXPECT_EQ(OutcomeOf(Figures(0.3, 0.4, 0.01)), RunOutcome::kWorse);
  EXPECT_EQ(OutcomeOf(Figures(0.4, 0.3, 0.01, 7)), RunOutcome::kCannotTell);
  EXPECT_EQ(OutcomeOf(ClosingFigures()), RunOutcome::kCannotTell);
  EXPECT_EQ(OutcomeOf(Figures(0.97, 0.91, 0.01)), RunOutcome::kCannotTell);
  ClosingFigures undone = Figures(0.4, 0.4, 0);
  undone.moved = false;
  EXPECT_EQ(OutcomeOf(undone), RunOutcome::kUndone);
  ClosingFigures in_part = Figures(0.4, 0.3, 0.01);
  in_part.against = 0.2;
  EXPECT_EQ(OutcomeOf(in_part), RunOutcome::kWorked);
  in_part.against = 0.1;
  in_part.featureless = 0.2;
  EXPECT_EQ(OutcomeOf(in_part), RunOutcome::kWorkedInPart);
  EXPECT_EQ(ClosingLine(in_part),
            "worked in part: mean 1 - ZNCC on held-back pairs 0.400 -> 0.300; 10 % is against the "
            "evidence, 20 % shows no texture to go by");
  in_part.held_back->after = 0.5;
  EXPECT_EQ(OutcomeOf(in_part), RunOutcome::kWorse);
}

TEST(Closing, LineSaysWhatIsKnownAndNothingElse) {
  ClosingFigures figures = Figures(0.412, 0.2874, 0.01);
  EXPECT_EQ(ClosingLine(figures), "worked: mean 1 - ZNCC on held-back pairs 0.412 -> 0.287");
  figures.unseen = 0.123;
  figures.against = 0.0304;
  figures.parts = 5;
  figures.parts_out = 2;
  figures.parts_out_area = 0.0004;
  EXPECT_EQ(ClosingLine(figures),
            "worked: mean 1 - ZNCC on held-back pairs 0.412 -> 0.287; 12 % of the surface is seen "
            "by no pair, 3.0 % is against the evidence, 2 of 5 parts, less than 0.1 % of the area, "
            "took no part");
  EXPECT_EQ(ClosingJson(figures)["line"], ClosingLine(figures));
  EXPECT_TRUE(ClosingJson(ClosingFigures())["held_back"].is_null());
  EXPECT_THAT(ClosingLine(ClosingFigures()), HasSubstr("cannot tell"));
}

SyntheticOptions SmallOptions(SyntheticKind kind, int seed) {
  SyntheticOptions options = test::SmallReliefOptions(0);
  options.scene = kind;
  options.seed = seed;
  return options;
}

const SyntheticScene& Bodies() {
  static const auto* scene = [] {
    SyntheticOptions options = SmallOptions(SyntheticKind::kOccluders, 1);
    options.truth_point_count = 20000;
    return new SyntheticScene(MakeSyntheticScene(options));
  }();
  return *scene;
}

// The largest one.
std::vector<int> SomeBody(const TriangleMesh& mesh) {
  std::vector<PartSides> parts = LookAtParts({}, mesh);
  std::sort(parts.begin(), parts.end(),
            [](const PartSides& a, const PartSides& b) { return a.area > b.area; });
  return parts.at(1).faces;  // after the wall
}

TriangleMesh OneBodyInsideOut() {
  TriangleMesh mesh = Bodies().init;
  for (const int f : SomeBody(mesh)) std::swap(mesh.faces[f][1], mesh.faces[f][2]);
  return mesh;
}

double F1(const TriangleMesh& mesh, const char* tau_px) {
  Truth truth;
  truth.cloud.points = Bodies().truth_points;
  truth.cloud.normals = Bodies().truth_normals;
  EvaluationOptions options;
  options.unit = Bodies().footprint;
  options.tau = tau_px;
  options.unmatched = UnmatchedSamples::kDrop;
  options.sample_count = 100000;
  return EvaluateMesh(mesh, truth, options).scores[0].f1;
}

struct Finished {
  PipelineResult result;
  MeshParts parts;
};

Finished RunWith(OrientMesh orient, TriangleMesh mesh) {
  PipelineOptions options;
  options.mesh.orient = orient;
  Finished run;
  run.parts = OrientAndCheck(Bodies().scene, options.mesh, "mesh.ply", &mesh);
  run.result = RunPipeline(Bodies().scene, mesh, options);
  CloseParts(mesh, &run.result, &run.parts);
  return run;
}

// It was refined without it, and nothing said so.
TEST(Closing, ABodyInsideOutIsNamedOrTurned) {
  const Finished off = RunWith(OrientMesh::kOff, OneBodyInsideOut());
  ASSERT_THAT(off.parts.lines, SizeIs(1));
  EXPECT_THAT(off.parts.lines[0], HasSubstr("seen from behind only: they take no part"));
  EXPECT_EQ(off.result.closing->parts_out, 1);
  EXPECT_THAT(ClosingLine(*off.result.closing), HasSubstr("took no part"));
  EXPECT_EQ(PartsJson(off.parts)["inside_out"], 1);

  const Finished on = RunWith(OrientMesh::kOn, OneBodyInsideOut());
  ASSERT_THAT(on.parts.lines, SizeIs(1));
  EXPECT_THAT(on.parts.lines[0], HasSubstr("their faces are turned"));
  EXPECT_EQ(on.result.closing->parts_out, 0);
  EXPECT_EQ(PartsJson(on.parts)["turned"], 1);
  EXPECT_EQ(OutcomeOf(*on.result.closing), RunOutcome::kWorked);

  const Finished right = RunWith(OrientMesh::kOff, Bodies().init);
  EXPECT_THAT(right.parts.lines, IsEmpty());
  EXPECT_NEAR(F1(on.result.mesh, "1"), F1(right.result.mesh, "1"), 0.002);
  EXPECT_LT(F1(off.result.mesh, "0.3"), F1(right.result.mesh, "0.3") - 0.01);
}

// Sums differ by the number of windows, 4 to 1 from level to level.
TEST(Closing, EnergiesPerWindowCompareFromLevelToLevel) {
  const SyntheticScene made = MakeSyntheticScene(test::SmallReliefOptions(7));
  const PipelineResult result = RunPipeline(made.scene, made.init, PipelineOptions());
  RunInputs inputs;
  inputs.scene = &made.scene;
  inputs.mesh = &made.init;
  const nlohmann::ordered_json summary = SummaryJson(inputs, PipelineOptions(), result, 1);
  for (const auto& level : summary["levels"]) {
    for (const auto& round : level["rounds"]) {
      for (const std::string when : {"initial", "final"}) {
        const double windows = round["windows_" + when];
        for (const auto& [term, energy] : round["energy_" + when].items()) {
          EXPECT_DOUBLE_EQ(round["energy_per_window_" + when][term].get<double>() * windows,
                           energy.get<double>());
        }
      }
    }
  }
  const auto& coarse = summary["levels"][0]["rounds"].back();
  const auto& fine = summary["levels"].back()["rounds"][0];
  EXPECT_GT(fine["energy_initial"]["photometric"],
            2 * coarse["energy_final"]["photometric"].get<double>());
  EXPECT_NEAR(fine["energy_per_window_initial"]["photometric"],
              coarse["energy_per_window_final"]["photometric"].get<double>(), 0.1);
}

TEST(Closing, NothingOfARightMeshIsTurned) {
  for (const SyntheticKind kind :
       {SyntheticKind::kRelief, SyntheticKind::kOccluders, SyntheticKind::kRods,
        SyntheticKind::kPlates, SyntheticKind::kMembrane, SyntheticKind::kSky}) {
    for (int seed = 1; seed <= 3; ++seed) {
      const SyntheticScene made = MakeSyntheticScene(SmallOptions(kind, seed));
      TriangleMesh mesh = made.init;
      const MeshParts parts = OrientAndCheck(made.scene, MeshOptions(), "mesh.ply", &mesh);
      EXPECT_THAT(parts.lines, IsEmpty()) << NameOf(kind) << " " << seed;
      EXPECT_EQ(mesh.faces, made.init.faces);
    }
  }
}

TEST(Closing, AMeshInsideOutIsTurnedWholeOrRefused) {
  TriangleMesh mesh = Bodies().init;
  for (Eigen::Vector3i& face : mesh.faces) std::swap(face[1], face[2]);
  MeshOptions off;
  off.orient = OrientMesh::kOff;
  EXPECT_THROW(OrientAndCheck(Bodies().scene, off, "mesh.ply", &mesh), InputError);
  OrientAndCheck(Bodies().scene, MeshOptions(), "mesh.ply", &mesh);
  EXPECT_EQ(mesh.faces, Bodies().init.faces);
}

// Two cameras leave no pair to hold back: squares of the images are.
TEST(Closing, TwoViewsAreComparedBySquares) {
  const SyntheticScene made = MakeSyntheticScene(test::SmallReliefOptions(2));
  const PipelineResult result = RunPipeline(made.scene, made.init, PipelineOptions());
  EXPECT_EQ(result.closing->judged_by, "squares");
  EXPECT_EQ(OutcomeOf(*result.closing), RunOutcome::kWorked);
}

// It agrees better than before wherever it found the surface, and has not found it elsewhere.
TEST(Closing, AMeshHalfTooLargeWorksInPart) {
  const SyntheticScene made = MakeSyntheticScene(test::SmallReliefOptions(0));
  TriangleMesh large = made.init;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& vertex : large.vertices) middle += vertex;
  middle /= static_cast<double>(large.vertices.size());
  for (Eigen::Vector3d& vertex : large.vertices) vertex = middle + 1.5 * (vertex - middle);
  const PipelineResult result = RunPipeline(made.scene, large, PipelineOptions());
  RecordProperty("closing_line", ClosingLine(*result.closing));
  EXPECT_EQ(OutcomeOf(*result.closing), RunOutcome::kWorkedInPart);
  EXPECT_THAT(ClosingLine(*result.closing), HasSubstr("of the facets cross others"));
  EXPECT_EQ(OutcomeOf(*RunPipeline(made.scene, made.init, PipelineOptions()).closing),
            RunOutcome::kWorked);
}

class UndoesAll : public LevelJudge {
 public:
  const std::vector<CameraPair>& HeldBackPairs() const override { return pairs_; }
  void BeginLevel(const RoundContext& /*first*/, const TermRounds& /*terms*/,
                  LevelFacets /*facets*/, const nlohmann::json& /*report*/) override {}
  LevelVerdict EndLevel(const RoundContext& /*last*/, const TermRounds& /*terms*/,
                        const TriangleMesh& after) override {
    return {std::vector<char>(after.vertices.size(), 1), nullptr};
  }

 private:
  std::vector<CameraPair> pairs_;
};

TEST(Closing, AMeshThatNothingMovedIsUndone) {
  UndoesAll judge;
  PipelineParts parts;
  parts.judge = &judge;
  const PipelineResult result =
      RunPipeline(Bodies().scene, Bodies().init, PipelineOptions(), parts);
  EXPECT_EQ(OutcomeOf(*result.closing), RunOutcome::kUndone);
}

}  // namespace
}  // namespace burin
