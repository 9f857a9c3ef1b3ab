// What is cut away of a refined mesh, and what stays (core/evidence/trim.h, apps/run/trim_surface.h).
#include "core/evidence/trim.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/run/pipeline.h"
#include "apps/run/run_output.h"
#include "core/synthetic/synthetic.h"
#include "costs/surface_evidence.h"
#include "tests/program_test.h"
#include "tests/small_relief.h"
#include "tests/test_scene.h"
#include "tests/test_shapes.h"

namespace burin {
namespace {

FacetEvidence WellKnown() {
  FacetEvidence facet;
  facet.pairs = 6;
  facet.clear_pairs = 4;
  facet.cosine = 0.8F;
  facet.zncc = 0.7F;
  facet.sd_px = 0.1F;
  facet.front = 50;
  return facet;
}

TEST(Trim, TheFirstReasonThatHolds) {
  struct Case {
    CutReason reason;
    void (*spoil)(FacetEvidence*);
  };
  const std::vector<Case> cases = {
      {CutReason::kNone, [](FacetEvidence*) {}},
      {CutReason::kNone, [](FacetEvidence* f) { f->clear_pairs = 2; }},
      {CutReason::kUnclear, [](FacetEvidence* f) { f->clear_pairs = 1; }},
      {CutReason::kNone, [](FacetEvidence* f) { f->cosine = 0.31F; }},
      {CutReason::kGrazing, [](FacetEvidence* f) { f->cosine = 0.29F; }},
      {CutReason::kNone, [](FacetEvidence* f) { f->sd_px = 2.9F; }},
      {CutReason::kUncertain, [](FacetEvidence* f) { f->sd_px = 3.1F; }},
      {CutReason::kNone, [](FacetEvidence* f) { f->zncc = 0.01F; }},
      {CutReason::kDisagrees, [](FacetEvidence* f) { f->zncc = -0.01F; }},
      // Nothing is known of windows: no reason.
      {CutReason::kNone, [](FacetEvidence* f) { f->zncc = f->sd_px = std::nanf(""); }},
      {CutReason::kUnseen,
       [](FacetEvidence* f) {
         f->pairs = f->clear_pairs = 0;
         f->cosine = 0;
         f->sd_px = 9;
       }},
  };
  for (size_t k = 0; k < cases.size(); ++k) {
    SCOPED_TRACE(k);
    FacetEvidence facet = WellKnown();
    cases[k].spoil(&facet);
    EXPECT_EQ(JudgeFacet(SurfaceTrim::kEvidence, facet), cases[k].reason);
    EXPECT_EQ(JudgeFacet(SurfaceTrim::kUnseen, facet),
              facet.pairs == 0 ? CutReason::kUnseen : CutReason::kNone);
    EXPECT_EQ(JudgeFacet(SurfaceTrim::kNone, facet), CutReason::kNone);
  }
}

// A sheet of 60 x 60 squares of 36 square pixels each, all well known, with `change` on the facets whose middle is chosen.
class Sheet {
 public:
  Sheet() : mesh_(Plane(0, 360, 60)), facets_(mesh_.faces.size(), WellKnown()) {}
  void Change(double left, double right, double top, double bottom,
              const std::function<void(FacetEvidence*)>& change) {
    for (size_t f = 0; f < facets_.size(); ++f) {
      if (In(f, left, right, top, bottom)) change(&facets_[f]);
    }
  }
  // Share of the facets there that are cut, and for that reason.
  double Cut(double left, double right, double top, double bottom, CutReason reason) const {
    const std::vector<double> areas(facets_.size(), 18);
    const std::vector<CutReason> reasons =
        FacetsToCut(SurfaceTrim::kEvidence, mesh_, facets_, areas);
    double all = 0;
    double cut = 0;
    for (size_t f = 0; f < facets_.size(); ++f) {
      if (!In(f, left, right, top, bottom)) continue;
      ++all;
      if (reasons[f] == reason) ++cut;
    }
    return cut / all;
  }

 private:
  bool In(size_t f, double left, double right, double top, double bottom) const {
    const Eigen::Vector3i& face = mesh_.faces[f];
    const Eigen::Vector3d at =
        (mesh_.vertices[face[0]] + mesh_.vertices[face[1]] + mesh_.vertices[face[2]]) / 3;
    return at.x() > left && at.x() < right && at.y() > top && at.y() < bottom;
  }
  TriangleMesh mesh_;
  std::vector<FacetEvidence> facets_;
};

void MakeNarrow(FacetEvidence* facet) {
  facet->thin = true;
  facet->clear_pairs = 0;
  facet->cosine = 0.1F;
  facet->sd_px = 5;
  facet->zncc = -0.5F;
}

TEST(Trim, NarrowPartsAreCutOnEvidenceAgainstThemOnly) {
  Sheet sheet;
  sheet.Change(60, 84, 60, 300, MakeNarrow);
  EXPECT_EQ(sheet.Cut(60, 84, 60, 300, CutReason::kNone), 1);
  // Unseen in part, as the back of a rod.
  sheet.Change(60, 72, 60, 300, [](FacetEvidence* f) { f->pairs = 0; });
  EXPECT_EQ(sheet.Cut(60, 84, 60, 300, CutReason::kNone), 1);
  sheet.Change(60, 84, 60, 180, [](FacetEvidence* f) { f->behind = f->front + 1; });
  EXPECT_GT(sheet.Cut(60, 84, 60, 170, CutReason::kRefuted), 0.9);
  EXPECT_EQ(sheet.Cut(60, 84, 190, 300, CutReason::kNone), 1);
  sheet.Change(60, 84, 180, 300, [](FacetEvidence* f) { f->outside = f->front / 2 + 1; });
  EXPECT_GT(sheet.Cut(60, 84, 60, 300, CutReason::kRefuted), 0.9);
}

TEST(Trim, FoldsAreNoNarrowParts) {
  Sheet sheet;
  sheet.Change(60, 84, 60, 300, MakeNarrow);
  sheet.Change(60, 78, 60, 300, [](FacetEvidence* f) { f->pairs = 0; });
  EXPECT_LT(sheet.Cut(60, 84, 60, 300, CutReason::kNone), 0.02);
  EXPECT_GT(sheet.Cut(60, 78, 60, 300, CutReason::kUnseen), 0.9);
  // Nor is a plate: it is seen clear of its outline.
  Sheet plate;
  plate.Change(60, 240, 60, 240, [](FacetEvidence* f) { f->thin = true; });
  plate.Change(60, 240, 60, 150, [](FacetEvidence* f) { f->pairs = f->clear_pairs = 0; });
  EXPECT_GT(plate.Cut(60, 240, 60, 140, CutReason::kUnseen), 0.9);
}

TEST(Trim, SurfacesSeenAtASmallAngleAreNoBridges) {
  const auto oblique = [](FacetEvidence* f) {
    f->clear_pairs = 0;
    f->off_step_pairs = 4;
    f->cosine = 0.2F;
    f->zncc = 0.5F;
  };
  Sheet ground;
  ground.Change(60, 300, 60, 300, oblique);
  EXPECT_EQ(ground.Cut(60, 300, 60, 300, CutReason::kNone), 1);
  Sheet bridge;
  bridge.Change(60, 78, 60, 108, oblique);  // of 864 square pixels
  EXPECT_GT(bridge.Cut(60, 78, 60, 108, CutReason::kUnclear), 0.9);
  Sheet apart;
  apart.Change(60, 300, 60, 300, oblique);
  apart.Change(60, 300, 60, 300, [](FacetEvidence* f) { f->zncc = 0.3F; });
  EXPECT_GT(apart.Cut(60, 300, 60, 300, CutReason::kUnclear), 0.85);
  Sheet step;
  step.Change(60, 300, 60, 300, oblique);
  step.Change(60, 300, 60, 300, [](FacetEvidence* f) { f->off_step_pairs = 1; });
  EXPECT_GT(step.Cut(60, 300, 60, 300, CutReason::kUnclear), 0.85);
}

struct Frozen {
  std::vector<LevelView> views;
  std::vector<ViewDomain> domains;
  Adjacency faces;
  std::vector<char> boundary;
  SurfaceEvidence Measure(const TriangleMesh& mesh) const {
    return MeasureSurfaceEvidence({mesh, faces, boundary, views, domains});
  }
};

Frozen Freeze(const TriangleMesh& mesh, std::vector<LevelView> views,
              const std::vector<CameraPair>& pairs) {
  Frozen frozen;
  frozen.views = std::move(views);
  std::vector<Camera> cameras;
  std::vector<cv::Mat> masks;
  for (const LevelView& view : frozen.views) {
    cameras.push_back(view.camera);
    masks.push_back(view.mask);
  }
  frozen.domains = RayCaster(mesh).Cast(cameras, pairs, 1, masks);
  frozen.faces = VertexFaces(mesh);
  frozen.boundary = BoundaryVertices(mesh, frozen.faces);
  return frozen;
}

TEST(Trim, ASphereSeenFromAllSidesStaysClosed) {
  const TriangleMesh sphere = Sphere(1, 4);
  std::vector<LevelView> views;
  const TriangleMesh around = Sphere(4, 1);
  for (const Eigen::Vector3d& center : around.vertices) {
    views.emplace_back().camera = test::LookAt(center + Eigen::Vector3d(0.01, 0, 0.01),
                                               Eigen::Vector3d::Zero(), 200, 200, 300);
  }
  std::vector<CameraPair> pairs;
  for (size_t i = 0; i < views.size(); ++i) {
    for (size_t j = 0; j < views.size(); ++j) {
      const double apart = (around.vertices[i] - around.vertices[j]).norm();
      if (i != j && apart < 4.5) pairs.push_back({static_cast<int>(i), static_cast<int>(j)});
    }
  }
  const SurfaceEvidence evidence = Freeze(sphere, views, pairs).Measure(sphere);
  const std::vector<double> areas(sphere.faces.size(), 10);
  for (const CutReason reason :
       FacetsToCut(SurfaceTrim::kEvidence, sphere, evidence.facets, areas)) {
    EXPECT_EQ(reason, CutReason::kNone);
  }
  for (size_t v = 0; v < sphere.vertices.size(); ++v) {
    EXPECT_GT(evidence.cosine[v], 0.7F);
    EXPECT_GT(evidence.step_px[v], 20);
  }
}

// One pair of views from one side: its other side is not seen, and its outline is not clear.
TEST(Trim, ASphereSeenFromOneSideIsCutBehindItsOutline) {
  const TriangleMesh sphere = Sphere(1, 4);
  std::vector<LevelView> views;
  for (const double x : {-0.5, 0.5}) {
    views.emplace_back().camera = test::LookAt({x, 0, 4}, Eigen::Vector3d::Zero(), 200, 200, 300);
  }
  views[0].mask = cv::Mat1b(200, 200, static_cast<uchar>(255));
  views[0].mask.rowRange(100, 200).setTo(0);
  const Frozen frozen = Freeze(sphere, views, {{0, 1}, {1, 0}});
  const SurfaceEvidence evidence = frozen.Measure(sphere);
  for (size_t f = 0; f < sphere.faces.size(); ++f) {
    const FacetEvidence& facet = evidence.facets[f];
    EXPECT_LE(facet.clear_pairs, facet.off_step_pairs);
    EXPECT_LE(facet.off_step_pairs, facet.pairs);
    const Eigen::Vector3d normal = FaceAreaNormal(sphere, static_cast<int>(f)).normalized();
    if (normal.z() < -0.2) {
      EXPECT_EQ(facet.pairs, 0);
      EXPECT_EQ(facet.front, 0);
    }
    if (normal.z() < 0.8) continue;
    if (normal.y() > 0.1) {
      EXPECT_EQ(facet.clear_pairs, 2);
      EXPECT_EQ(facet.off_step_pairs, 2);
      EXPECT_GT(facet.cosine, 0.55F);
      EXPECT_EQ(facet.outside, 0);
    }
    if (normal.y() < -0.1) {
      EXPECT_EQ(facet.pairs, 0);  // the mask leaves it out
      // By the view that has the mask.
      EXPECT_NEAR(static_cast<double>(facet.outside), 0.5 * static_cast<double>(facet.front),
                  0.2 * static_cast<double>(facet.front));
    }
    EXPECT_EQ(facet.behind, 0);
  }
}

const SyntheticScene& Occluders() {
  static const auto* scene = [] {
    SyntheticOptions options = test::SmallReliefOptions(6);
    options.scene = SyntheticKind::kOccluders;
    return new SyntheticScene(MakeSyntheticScene(options));
  }();
  return *scene;
}

PipelineResult RunOccluders(SurfaceTrim trim, int threads = 0) {
  PipelineOptions options;
  options.surface.trim = trim;
  options.threads = threads;
  return RunPipeline(Occluders().scene, Occluders().init, options);
}

void ExpectSame(const std::vector<VertexScalar>& a, const std::vector<VertexScalar>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t k = 0; k < a.size(); ++k) {
    EXPECT_EQ(a[k].name, b[k].name);
    ASSERT_EQ(a[k].values.size(), b[k].values.size());
    for (size_t v = 0; v < a[k].values.size(); ++v) {
      if (std::isnan(a[k].values[v]) && std::isnan(b[k].values[v])) continue;
      EXPECT_EQ(a[k].values[v], b[k].values[v]);
    }
  }
}

class TrimFiles : public ProgramTest {};

TEST_F(TrimFiles, TheWholeStandsBesideWhatIsLeftAndIsWhatNoneGives) {
  const PipelineResult none = RunOccluders(SurfaceTrim::kNone, 2);
  EXPECT_FALSE(none.trimming.has_value());
  const PipelineResult trimmed = RunOccluders(SurfaceTrim::kEvidence, 1);
  ASSERT_TRUE(trimmed.trimming.has_value());
  EXPECT_EQ(trimmed.trimming->whole.vertices, none.mesh.vertices);
  EXPECT_EQ(trimmed.trimming->whole.faces, none.mesh.faces);
  ExpectSame(trimmed.trimming->quality, none.quality);
  const auto kept = std::count(trimmed.trimming->reasons.begin(), trimmed.trimming->reasons.end(),
                               CutReason::kNone);
  EXPECT_EQ(static_cast<size_t>(kept), trimmed.mesh.faces.size());
  EXPECT_LT(kept, 0.9 * static_cast<double>(none.mesh.faces.size()));  // backs of bodies
  EXPECT_GT(kept, 0.4 * static_cast<double>(none.mesh.faces.size()));
  for (const VertexScalar& scalar : trimmed.quality) {
    EXPECT_EQ(scalar.values.size(), trimmed.mesh.vertices.size());
  }
  const nlohmann::json json = TrimJson(*trimmed.trimming);
  int64_t cut = 0;
  for (const auto& count : json["cut"]) cut += count.get<int64_t>();
  EXPECT_EQ(cut + kept, json["faces"].get<int64_t>());
  EXPECT_GT(json["cut"]["unseen"], 0);
  EXPECT_THAT(TrimText(*trimmed.trimming), testing::HasSubstr(" seen by no pair"));

  const std::filesystem::path folder = In("");
  WriteSurface(folder, trimmed);
  const std::string whole = ReadAll(folder / "whole.ply");
  EXPECT_LT(ReadAll(folder / "refined.ply").size(), whole.size());
  WriteSurface(folder, none);
  EXPECT_EQ(ReadAll(folder / "refined.ply"), whole);
  EXPECT_FALSE(std::filesystem::exists(folder / "whole.ply"));
}

TEST(Trim, DoesNotDependOnThreads) {
  const PipelineResult one = RunOccluders(SurfaceTrim::kEvidence, 1);
  const PipelineResult many = RunOccluders(SurfaceTrim::kEvidence, 3);
  EXPECT_EQ(one.mesh.vertices, many.mesh.vertices);
  EXPECT_EQ(one.mesh.faces, many.mesh.faces);
  EXPECT_EQ(one.trimming->reasons, many.trimming->reasons);
  ExpectSame(one.quality, many.quality);
}

// Undoes every level: the result is the mesh given.
class UndoAll : public LevelJudge {
 public:
  const std::vector<CameraPair>& HeldBackPairs() const override { return pairs_; }
  void BeginLevel(const RoundContext& /*first*/, const TermRounds& /*terms*/,
                  LevelFacets /*facets*/, const nlohmann::json& /*report*/) override {}
  LevelVerdict EndLevel(const RoundContext& /*last*/, const TermRounds& /*terms*/,
                        const TriangleMesh& after) override {
    return {std::vector<char>(after.vertices.size(), 1), {}};
  }

 private:
  const std::vector<CameraPair> pairs_ = {{2, 5}};
};

TEST(Trim, AMeshThatIsHandedBackIsWhole) {
  UndoAll judge;
  PipelineOptions options;
  options.surface.trim = SurfaceTrim::kEvidence;
  options.refinement.guard.levels = false;
  options.refinement.level.finest = 1;
  PipelineParts parts;
  parts.judge = &judge;
  const PipelineResult result = RunPipeline(Occluders().scene, Occluders().init, options, parts);
  ASSERT_FALSE(result.refinement.levels.empty());
  EXPECT_FALSE(result.trimming.has_value());
}

// Rods of 1 to 3 px: none of their pixels is clear of their outlines.
TEST(Trim, RodsAreKept) {
  SyntheticOptions scene;
  scene.scene = SyntheticKind::kRods;
  scene.width = 320;
  scene.height = 240;
  scene.samples_per_axis = 2;
  const SyntheticScene rods = MakeSyntheticScene(scene);
  PipelineOptions options;
  options.surface.trim = SurfaceTrim::kEvidence;
  const PipelineResult result = RunPipeline(rods.scene, rods.init, options);
  ASSERT_TRUE(result.trimming.has_value());
  const auto all = static_cast<double>(result.trimming->whole.faces.size());
  EXPECT_GT(static_cast<double>(result.mesh.faces.size()), 0.99 * all);
}

TEST(Trim, FacetsInFreeSpaceAreCut) {
  SyntheticOptions scene = test::SmallReliefOptions(7);
  scene.scene = SyntheticKind::kMembrane;
  scene.width = 320;
  scene.height = 240;
  scene.point_count = 2000;
  const SyntheticScene membrane = MakeSyntheticScene(scene);
  PipelineOptions options;
  options.surface.trim = SurfaceTrim::kUnseen;
  options.refinement.level.finest = 1;
  const PipelineResult result = RunPipeline(membrane.scene, membrane.init, options);
  ASSERT_EQ(result.free_space.patches.size(), 1U);
  ASSERT_TRUE(result.trimming.has_value());
  const size_t facets = result.free_space.patches[0].facets.size();
  EXPECT_EQ(static_cast<size_t>(std::count(result.trimming->reasons.begin(),
                                           result.trimming->reasons.end(), CutReason::kFreeSpace)),
            facets);
  EXPECT_LE(result.mesh.faces.size() + facets, result.trimming->whole.faces.size());
}

}  // namespace
}  // namespace burin
