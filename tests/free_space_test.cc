// Surface where photographs show free space, or nothing: it takes no part, and is not cut finer.
#include "core/evidence/free_space.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "apps/run/pipeline.h"
#include "core/mesh/projected_area.h"
#include "core/refine/facet_texture.h"
#include "core/refine/thin_parts.h"
#include "core/scene/near_depth.h"
#include "core/synthetic/synthetic.h"
#include "core/visibility/facet_map.h"
#include "core/visibility/visibility.h"
#include "selection/pair_selection.h"
#include "tests/split_facets.h"
#include "tests/test_scene.h"
#include "tests/test_shapes.h"

namespace burin {
namespace {

SyntheticOptions Options(SyntheticKind kind, int width = 400, int seed = 1) {
  SyntheticOptions options;
  options.scene = kind;
  options.width = width;
  options.height = 3 * width / 4;
  options.samples_per_axis = 2;
  options.seed = seed;
  return options;
}

// Made once for all tests.
const SyntheticScene& SceneOf(SyntheticKind kind) {
  static auto* scenes = new std::map<SyntheticKind, SyntheticScene>();
  const auto found = scenes->find(kind);
  if (found != scenes->end()) return found->second;
  return scenes->emplace(kind, MakeSyntheticScene(Options(kind))).first->second;
}

FreeSpace Find(const SyntheticScene& synthetic) {
  const PairSelection pairs = SelectPairs(synthetic.scene, synthetic.init, PairsOptions());
  return FindFreeSpace(synthetic.scene, synthetic.init, pairs.pairs);
}

// The facets that hang together with the mesh's last one: the sheet of `membrane`.
std::vector<char> LastPart(const TriangleMesh& mesh) {
  const std::vector<std::vector<int>> parts = ConnectedComponents(mesh);
  std::vector<char> in_last(mesh.faces.size(), 0);
  for (const int f : parts.back()) in_last[f] = 1;
  return in_last;
}

TEST(FreeSpace, TheSheetBeforeACameraIsFoundAndNothingElse) {
  const SyntheticScene& synthetic = SceneOf(SyntheticKind::kMembrane);
  const FreeSpace free_space = Find(synthetic);
  ASSERT_EQ(free_space.patches.size(), 1U);
  const std::vector<char> sheet = LastPart(synthetic.init);
  int found = 0;
  int all = 0;
  for (size_t f = 0; f < sheet.size(); ++f) {
    EXPECT_LE(free_space.facet[f], sheet[f]) << f;
    found += free_space.facet[f];
    all += sheet[f];
  }
  EXPECT_GT(found, 0.9 * all);
  ASSERT_FALSE(free_space.hidden.empty());
  EXPECT_EQ(free_space.hidden[0].view, synthetic.scene.views[3].name);
  EXPECT_NEAR(free_space.hidden[0].share, 1.0 / 3, 0.02);
}

TEST(FreeSpace, WithoutSparsePointsThePhotographsSayIt) {
  SyntheticScene synthetic = SceneOf(SyntheticKind::kMembrane);
  synthetic.scene.points.clear();
  synthetic.scene.tracks = Tracks();
  const FreeSpace free_space = Find(synthetic);
  ASSERT_EQ(free_space.patches.size(), 1U);
  EXPECT_GT(free_space.patches[0].facets.size(), 300U);
}

// Points of another scene, close together and far behind the surface, while the photographs fit.
TEST(FreeSpace, PointsThatAreElsewhereThanMeasuredSayNothing) {
  SyntheticScene synthetic = SceneOf(SyntheticKind::kRelief);
  const Eigen::Vector3d center = synthetic.scene.views[0].camera.Center();
  for (ScenePoint& point : synthetic.scene.points) {
    point.position = 0.2 * point.position - center;
  }
  EXPECT_TRUE(Find(synthetic).patches.empty());
  synthetic.scene.tracks = Tracks();  // without measurements nothing speaks against them
  EXPECT_FALSE(Find(synthetic).patches.empty());
}

// True occluders, thin things and gaps are not free space, with points and without.
class TrueSurface : public testing::TestWithParam<SyntheticKind> {};
INSTANTIATE_TEST_SUITE_P(Scenes, TrueSurface,
                         testing::Values(SyntheticKind::kRelief, SyntheticKind::kRods,
                                         SyntheticKind::kPlates),
                         [](const auto& scene) { return NameOf(scene.param); });
TEST_P(TrueSurface, IsNotFreeSpace) {
  SyntheticScene synthetic = SceneOf(GetParam());
  EXPECT_TRUE(Find(synthetic).patches.empty());
  synthetic.scene.points.clear();
  synthetic.scene.tracks = Tracks();
  EXPECT_TRUE(Find(synthetic).patches.empty());
}

TEST(FreeSpace, TheTruthOfOccludersIsNotFreeSpace) {
  SyntheticScene synthetic = SceneOf(SyntheticKind::kOccluders);
  synthetic.init = synthetic.truth;
  EXPECT_TRUE(Find(synthetic).patches.empty());
}

TEST(FreeSpace, ARunLeavesTheSheetAloneAndSeesThroughIt) {
  const SyntheticScene& synthetic = SceneOf(SyntheticKind::kMembrane);
  PipelineOptions options = test::SplitFacets();
  options.refinement.level.finest = 1;
  const auto run = [&](FreeSpaceAction action, FreeSpace* found) {
    options.surface.free_space = action;
    PipelineParts parts;
    parts.on_free_space = [&](const FreeSpace& free_space) { *found = free_space; };
    return RunPipeline(synthetic.scene, synthetic.init, options, parts);
  };
  FreeSpace found;
  const PipelineResult ignored = run(FreeSpaceAction::kIgnore, &found);
  ASSERT_EQ(found.patches.size(), 1U);
  // Put back where it stood, facet by facet.
  const size_t facets = found.patches[0].facets.size();
  for (size_t k = 0; k < facets; ++k) {
    const Eigen::Vector3i face = ignored.mesh.faces[ignored.mesh.faces.size() - facets + k];
    EXPECT_EQ(face, synthetic.init.faces[found.patches[0].facets[k]]);
  }
  FreeSpace none;
  const PipelineResult kept = run(FreeSpaceAction::kKeep, &none);
  EXPECT_TRUE(none.patches.empty());
  const PipelineResult cut = run(FreeSpaceAction::kCut, &found);
  EXPECT_EQ(cut.mesh.faces.size() + facets, ignored.mesh.faces.size());
  EXPECT_LT(cut.mesh.vertices.size(), ignored.mesh.vertices.size());
  for (const VertexScalar& scalar : cut.quality) {
    EXPECT_EQ(scalar.values.size(), cut.mesh.vertices.size());
  }
}

// The sheet has vertices of its own then.
TEST(FreeSpace, TheSheetIsPutBackIntoASurfaceThatIsCutAnew) {
  const SyntheticScene& synthetic = SceneOf(SyntheticKind::kMembrane);
  PipelineOptions options;
  options.refinement.level.finest = 1;
  options.refinement.surface.remesh = SurfaceFacets::kAdapted;
  options.surface.trim = SurfaceTrim::kNone;
  FreeSpace found;
  PipelineParts parts;
  parts.measure_quality = true;
  parts.on_free_space = [&](const FreeSpace& free_space) { found = free_space; };
  const PipelineResult ignored = RunPipeline(synthetic.scene, synthetic.init, options, parts);
  ASSERT_EQ(found.patches.size(), 1U);
  ASSERT_FALSE(ignored.refinement.levels.back().undone);
  const std::vector<int>& patch = found.patches[0].facets;
  const size_t before = ignored.mesh.faces.size() - patch.size();
  int lowest = static_cast<int>(ignored.mesh.vertices.size());
  for (size_t k = 0; k < patch.size(); ++k) {
    for (int c = 0; c < 3; ++c) {
      const int v = ignored.mesh.faces[before + k][c];
      EXPECT_EQ(ignored.mesh.vertices[v],
                synthetic.init.vertices[synthetic.init.faces[patch[k]][c]]);
      lowest = std::min(lowest, v);
    }
  }
  for (size_t f = 0; f < before; ++f) EXPECT_LT(ignored.mesh.faces[f].maxCoeff(), lowest);
  for (const VertexScalar& scalar : ignored.quality) {
    EXPECT_EQ(scalar.values.size(), ignored.mesh.vertices.size());
  }
  EXPECT_EQ(std::count(ignored.seen_with_part.begin(), ignored.seen_with_part.end(), 1), 1);
  options.surface.free_space = FreeSpaceAction::kCut;
  const PipelineResult cut = RunPipeline(synthetic.scene, synthetic.init, options, parts);
  EXPECT_EQ(cut.mesh.faces.size(), before);
}

// Two sheets before a camera that looks down z at the second.
TEST(NearDepth, WhatIsNearerIsNeitherSeenNorHides) {
  TriangleMesh mesh;
  const auto sheet = [&](double z, double half) {
    const auto first = static_cast<int>(mesh.vertices.size());
    for (const auto& [x, y] :
         std::vector<std::pair<double, double>>{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
      mesh.vertices.emplace_back(half * x, half * y, z);
    }
    mesh.faces.emplace_back(first, first + 1, first + 2);
    mesh.faces.emplace_back(first, first + 2, first + 3);
  };
  sheet(9, 0.1);  // at depth 1: covers a fifth of the image's width
  sheet(0, 20);   // at depth 10
  Camera camera = test::LookAt({0, 0, 10}, {0, 0, 0}, 100, 100, 100);
  const RayCaster caster(mesh);
  const auto sees = [&](int facets_from) {
    const cv::Mat1i map = FacetMap(mesh, camera);
    return std::count_if(map.begin(), map.end(), [&](int f) { return f >= facets_from; });
  };
  EXPECT_EQ(sees(2), 100 * 100 - 20 * 20);
  std::vector<uint8_t> visible;
  const std::vector<Eigen::Vector3d> points = {{0.1, 0.2, 0}, {2, 2, 0}, {0.01, 0.02, 9}};
  caster.PointsVisible(camera, points, {2, 2, 0}, &visible);
  EXPECT_EQ(visible, (std::vector<uint8_t>{0, 1, 1}));
  camera.near_depth = 2;
  EXPECT_EQ(sees(2), 100 * 100);
  caster.PointsVisible(camera, points, {2, 2, 0}, &visible);
  EXPECT_EQ(visible, (std::vector<uint8_t>{1, 1, 0}));
  EXPECT_EQ(camera.InScaledWorld({1, 2, 3}, 0.5).near_depth, 1);
}

// A strip of width 2 on the ground from below the camera on to far away: between depths d1 and d2 its image
// has the area f^2 h (1/d1 - 1/d2) (d1 + ... ) of a trapezium, here by its two parallel sides.
TEST(NearDepth, OnlyWhatLiesBehindItHasArea) {
  Camera camera = test::LookAt({0, 0, 0}, {0, 0, -1}, 10000, 10000, 100);
  const double far = 50;
  const auto area = [&] {
    return ProjectedArea(camera, {-1, -1, -1}, {1, -1, -1}, {1, -1, -far}) +
           ProjectedArea(camera, {-1, -1, -1}, {1, -1, -far}, {-1, -1, -far});
  };
  const auto trapezium = [&](double near) {
    const double height = 100 * (1 / near - 1 / far);
    return 0.5 * height * (200 / near + 200 / far);
  };
  EXPECT_NEAR(area(), trapezium(1), 1e-6 * trapezium(1));
  camera.near_depth = 5;
  EXPECT_NEAR(area(), trapezium(5), 1e-6 * trapezium(5));
  camera.near_depth = 60;
  EXPECT_EQ(area(), 0);
}

TEST(NearDepth, IsATwentiethOfTheNearestMeasuredDepths) {
  Scene scene;
  scene.views.resize(2);
  scene.views[0].camera = scene.views[1].camera = test::LookAt({0, 0, 0}, {0, 0, -1}, 9, 9, 9);
  for (int k = 1; k <= 100; ++k) {
    ScenePoint point;
    point.position = {0, 0, -static_cast<double>(k)};
    point.views = {0};
    if (k <= 49) point.views.push_back(1);
    scene.points.push_back(point);
  }
  SetNearDepths(&scene);
  EXPECT_DOUBLE_EQ(scene.views[0].camera.near_depth, 0.1);
  EXPECT_EQ(scene.views[1].camera.near_depth, 0);  // too few
}

TEST(NearDepth, PointsThatAreElsewhereThanMeasuredSayNothing) {
  Scene scene = SceneOf(SyntheticKind::kRelief).scene;
  for (ScenePoint& point : scene.points) point.position.z() -= 100;
  SetNearDepths(&scene);
  for (const View& view : scene.views) EXPECT_EQ(view.camera.near_depth, 0);
  scene.tracks = Tracks();
  SetNearDepths(&scene);
  for (const View& view : scene.views) EXPECT_GT(view.camera.near_depth, 4);
}

TEST(FacetTexture, IsWhatTwoViewsShow) {
  std::vector<LevelView> views(3);
  for (int i = 0; i < 3; ++i) {
    views[i].camera = test::LookAt({i - 1.0, 0, 10}, {i - 1.0, 0, 0}, 100, 100, 100);
    views[i].image = cv::Mat1f(100, 100, 100.0F);
    views[i].contrast = 40;
    views[i].noise_sigma = 0.5;
  }
  // A textured square around world point (1, 1, 0) in the first two views.
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector2d at = views[i].camera.Project({1, 1, 0});
    for (int y = -4; y <= 4; ++y) {
      for (int x = -4; x <= 4; ++x) {
        views[i].image.at<float>(static_cast<int>(at.y()) + y, static_cast<int>(at.x()) + x) +=
            static_cast<float>(6 * ((x + y) % 2));
      }
    }
  }
  TriangleMesh mesh = Plane(0, 10);
  for (Eigen::Vector3d& vertex : mesh.vertices) vertex -= Eigen::Vector3d(5, 5, 0);
  const auto textured = [&] {
    return FacetTexture(views, mesh).InTwoViews({-3, -3, 0}, {4, -3, 0}, {3, 4, 0});
  };
  EXPECT_TRUE(textured());
  EXPECT_FALSE(FacetTexture(views, mesh).InTwoViews({-3, -3, 0}, {-1, -3, 0}, {-1, -1, 0}));
  EXPECT_FALSE(
      FacetTexture(views, mesh).InTwoViews({3, 4, 0}, {4, -3, 0}, {-3, -3, 0}));  // its back
  views[1].at.takes_part = false;
  EXPECT_FALSE(textured());
  views[1].at.takes_part = true;
  views[1].noise_sigma = 3;
  EXPECT_FALSE(textured());
  views[1].noise_sigma = 0.5;
  EXPECT_TRUE(textured());
  // Something before it.
  const TriangleMesh cover = Plane(1, 4);
  const auto first = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), cover.vertices.begin(), cover.vertices.end());
  for (const Eigen::Vector3i& face : cover.faces) mesh.faces.emplace_back(face.array() + first);
  EXPECT_FALSE(textured());
}

// The part of the curtain that has sky behind it: what no photograph shows is not cut finer.
TEST(FacetTexture, SkyIsNotCutIntoPixels) {
  const SyntheticScene& synthetic = SceneOf(SyntheticKind::kSky);
  const std::vector<char> curtain = LastPart(synthetic.init);
  const PipelineResult result = RunPipeline(synthetic.scene, synthetic.init, test::SplitFacets());
  // By part of the result that hangs together with the curtain's vertices.
  const auto first =
      static_cast<size_t>(std::find(curtain.begin(), curtain.end(), 1) - curtain.begin());
  const int vertex = synthetic.init.faces[first][0];
  size_t finer = 0;
  for (const std::vector<int>& part : ConnectedComponents(result.mesh)) {
    const bool is_curtain = std::any_of(part.begin(), part.end(), [&](int f) {
      return (result.mesh.faces[f].array() == vertex).any();
    });
    if (is_curtain) finer += part.size();
  }
  const auto before = std::count(curtain.begin(), curtain.end(), 1);
  RecordProperty("facets_of_the_curtain", std::to_string(before) + " " + std::to_string(finer) +
                                              " of " + std::to_string(result.mesh.faces.size()));
  EXPECT_LT(finer, static_cast<size_t>(6 * before));
}

TEST(ThinVertices, AreThoseOfTubesAndSpheresThinnerThanTheWidth) {
  const TriangleMesh ball = Sphere(2, 3);
  const std::vector<Eigen::Vector3d> normals = VertexNormals(ball, VertexFaces(ball));
  const auto thin = [&](double width) {
    const std::vector<char> found = ThinVertices(ball, normals, width);
    return std::count(found.begin(), found.end(), 1);
  };
  EXPECT_EQ(thin(3.8), 0);
  EXPECT_EQ(thin(4.2), static_cast<long>(ball.vertices.size()));
  // An open sheet has no inside.
  const TriangleMesh plane = Plane(0);
  const std::vector<char> none = ThinVertices(plane, VertexNormals(plane, VertexFaces(plane)), 10);
  EXPECT_EQ(std::count(none.begin(), none.end(), 1), 0);
}

}  // namespace
}  // namespace burin
