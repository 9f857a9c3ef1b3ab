// A mesh to start from: the parts against closed forms and brute force, the whole on a sphere.
#include "reconstruct/start_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "core/mesh/manifold_cut.h"
#include "core/mesh/mesh_check.h"
#include "core/support/counter_random.h"
#include "core/support/error.h"
#include "core/support/parallel.h"
#include "reconstruct/cut_surface.h"
#include "reconstruct/minimum_cut.h"
#include "reconstruct/sight_costs.h"
#include "reconstruct/sight_walk.h"
#include "reconstruct/sighted_points.h"
#include "reconstruct/triangulation.h"

namespace burin {
namespace {

using Eigen::Vector3d;

std::vector<Vector3d> RandomPoints(int count, std::uint64_t seed) {
  const CounterRandom random(seed, /*stream=*/1);
  std::vector<Vector3d> points;
  points.reserve(count);
  for (int p = 0; p < count; ++p) {
    points.emplace_back(random.Uniform(3 * p), random.Uniform(3 * p + 1),
                        random.Uniform(3 * p + 2));
  }
  return points;
}

SightedPoints WithoutSights(const std::vector<Vector3d>& positions) {
  SightedPoints points;
  points.positions = positions;
  points.footprints.assign(positions.size(), 1);
  points.begin.assign(positions.size() + 1, 0);
  return points;
}

TEST(Triangulation, IsDelaunayAndItsCellsAreNeighboursBothWays) {
  const std::vector<Vector3d> points = RandomPoints(60, 1);
  const Tetrahedra tetrahedra = Triangulate(points);
  double volume = 0;
  for (int c = 0; c < tetrahedra.CellCount(); ++c) {
    for (int k = 0; k < 4; ++k) EXPECT_GE(tetrahedra.FacetTo(tetrahedra.neighbors[c][k], c), 0);
    if (tetrahedra.IsInfinite(c)) continue;
    const std::array<int, 4>& t = tetrahedra.corners[c];
    ASSERT_EQ(Orientation(points[t[0]], points[t[1]], points[t[2]], points[t[3]]), 1);
    Eigen::Matrix3d edges;
    for (int k = 0; k < 3; ++k) edges.row(k) = points[t[k + 1]] - points[t[0]];
    volume += edges.determinant() / 6;
    const Vector3d center = edges.inverse() * (edges.rowwise().squaredNorm() / 2);
    for (const Vector3d& other : points) {
      EXPECT_GE((other - points[t[0]] - center).norm(), center.norm() - 1e-9);
    }
    for (int k = 0; k < 4; ++k) {  // the corner opposite a facet is on its inner side
      const std::array<int, 3> f = tetrahedra.Facet(c, k);
      EXPECT_EQ(Orientation(points[f[0]], points[f[1]], points[f[2]], points[t[k]]), -1);
    }
  }
  EXPECT_GT(volume, 0.4);
  EXPECT_LT(volume, 1);
}

TEST(Triangulation, RefusesPointsInOnePlane) {
  std::vector<Vector3d> points = RandomPoints(20, 2);
  for (Vector3d& point : points) point.z() = 0.5;
  EXPECT_THROW(Triangulate(points), InputError);
  EXPECT_THROW(Triangulate({}), InputError);
}

TEST(MinimumCut, IsAsCheapAsTheBestOfAllDivisions) {
  const std::vector<Vector3d> points = RandomPoints(6, 3);
  const Tetrahedra tetrahedra = Triangulate(points);
  const int cells = tetrahedra.CellCount();
  ASSERT_LE(cells, 20);
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const CounterRandom random(seed, /*stream=*/2);
    CutCosts costs(cells);
    for (int c = 0; c < cells; ++c) {
      costs.outside[c] = static_cast<int>(30 * random.Uniform(5 * c));
      for (int k = 0; k < 4; ++k) {
        costs.facet[c][k] = static_cast<int>(10 * random.Uniform(5 * c + k + 1));
      }
    }
    costs.must_be_outside[static_cast<int>(seed) % cells] = 1;
    const auto price = [&](const auto& is_inside) {
      long sum = 0;
      for (int c = 0; c < cells; ++c) {
        if (is_inside(c)) {
          if (costs.must_be_outside[c] != 0) return std::numeric_limits<long>::max();
          continue;
        }
        sum += costs.outside[c];
        for (int k = 0; k < 4; ++k) {
          if (is_inside(tetrahedra.neighbors[c][k])) sum += costs.facet[c][k];
        }
      }
      return sum;
    };
    long best = std::numeric_limits<long>::max();
    int most_inside = 0;
    for (unsigned bits = 0; bits < 1U << cells; ++bits) {
      const long cost = price([bits](int c) { return (bits >> c & 1U) != 0; });
      const int inside = __builtin_popcount(bits);
      if (cost < best || (cost == best && inside > most_inside)) {
        best = cost;
        most_inside = inside;
      }
    }
    const std::vector<char> inside = MinimumCut(tetrahedra, costs);
    EXPECT_EQ(price([&](int c) { return inside[c] != 0; }), best);
    EXPECT_EQ(std::count(inside.begin(), inside.end(), 1), most_inside);
  }
}

TEST(SightWalk, CrossesFacetsInOrderAndEndsAtTheTarget) {
  const std::vector<Vector3d> points = RandomPoints(300, 4);
  const Tetrahedra tetrahedra = Triangulate(points);
  const SightWalk walk(points, tetrahedra);
  const std::vector<Vector3d> targets = RandomPoints(300, 5);
  int inside_hull = 0;
  for (int p = 0; p < 300; ++p) {
    const Vector3d direction = (targets[p] - points[p]).normalized();
    double before = 0;
    int from = -1;
    const int end = walk.Walk(p, targets[p], [&](int cell, int k) {
      EXPECT_TRUE(from < 0 || cell == from);
      const double d = walk.DistanceToFacet(p, direction, cell, k);
      EXPECT_GE(d, before - 1e-9);
      before = d;
      from = tetrahedra.neighbors[cell][k];
    });
    ASSERT_GE(end, 0);
    if (tetrahedra.IsInfinite(end)) continue;
    ++inside_hull;
    EXPECT_LE(before, (targets[p] - points[p]).norm() + 1e-9);
    for (int k = 0; k < 4; ++k) {
      const std::array<int, 3> f = tetrahedra.Facet(end, k);
      EXPECT_LE(Orientation(points[f[0]], points[f[1]], points[f[2]], targets[p]), 0);
    }
  }
  EXPECT_GT(inside_hull, 200);
}

// Divisions at random have every way in which facets can meet at edges and vertices.
TEST(CutSurface, IsManifoldForAnyDivision) {
  const std::vector<Vector3d> points = RandomPoints(200, 6);
  const Tetrahedra tetrahedra = Triangulate(points);
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const CounterRandom random(seed, /*stream=*/3);
    std::vector<char> inside(tetrahedra.CellCount());
    for (int c = 0; c < tetrahedra.CellCount(); ++c) {
      inside[c] = !tetrahedra.IsInfinite(c) && random.Uniform(c) < 0.5 ? 1 : 0;
    }
    const double limit = seed == 0 ? 10 : 0.3;  // none of the facets, or some, are dropped
    const CutSurface surface = SurfaceOfCut(WithoutSights(points), tetrahedra, inside, {limit, 1});
    const MeshReport report = CheckMesh(surface.mesh);
    EXPECT_GT(report.face_count, 300);
    EXPECT_EQ(surface.long_facets > 0, seed != 0);
    EXPECT_EQ(report.nonmanifold_edge_count, 0);
    EXPECT_EQ(report.inconsistent_edge_count, 0);
    EXPECT_EQ(report.degenerate_face_count, 0);
    EXPECT_EQ(report.unreferenced_vertex_count, 0);
    EXPECT_TRUE(seed != 0 || report.boundary_edge_count < 20);
    const std::vector<int> labels = LabelCorners(surface.mesh);
    EXPECT_EQ(std::set<int>(labels.begin(), labels.end()).size(), surface.mesh.vertices.size());
  }
}

TEST(SightedPoints, MergesWithinTheSmallerFootprint) {
  SightedPoints points;
  Camera camera;
  camera.width = camera.height = 100;
  camera.fx = camera.fy = 100;
  const std::vector<Camera> cameras(3, camera);
  points.Add({0, 0, 1}, {0}, cameras);  // footprint .01
  points.Add({0.006, 0, 1}, {1, 2}, cameras);
  points.Add({0.014, 0, 1}, {0, 1}, cameras);
  points.Add({0, 0.02, 1}, {2}, cameras);
  const SightedPoints merged = Merged(points, 0.7);
  ASSERT_EQ(merged.Count(), 3);
  EXPECT_NEAR(merged.positions[0].x(), 0.006, 1e-5);
  EXPECT_EQ(std::vector<int>(merged.views.begin(), merged.views.begin() + merged.begin[1]),
            (std::vector<int>{0, 1, 2}));
}

// A unit sphere seen from twenty directions, each point by the views in front of it, at most `most`.
Scene SphereScene(int count, int most) {
  Scene scene;
  const auto around = [](int i, int n) {  // evenly over the sphere
    const double z = 1 - (2 * i + 1.0) / n;
    const double angle = 2.399963229728653 * i;
    return Vector3d(std::sqrt(1 - z * z) * std::cos(angle), std::sqrt(1 - z * z) * std::sin(angle),
                    z);
  };
  for (int v = 0; v < 20; ++v) {
    View view;
    Camera& camera = view.camera;
    camera.width = camera.height = 400;
    camera.fx = camera.fy = 500;
    camera.cx = camera.cy = 200;
    const Vector3d center = 4 * around(v, 20);
    const Vector3d forward = -center.normalized();
    const Vector3d right = forward.unitOrthogonal();
    camera.rotation << right.transpose(), forward.cross(right).transpose(), forward.transpose();
    camera.translation = -camera.rotation * center;
    view.name = std::to_string(v);
    scene.views.push_back(view);
  }
  for (int p = 0; p < count; ++p) {
    ScenePoint point;
    point.position = around(p, count);
    for (int v = 0; v < 20 && static_cast<int>(point.views.size()) < most; ++v) {
      const Vector3d to_camera = scene.views[v].camera.Center() - point.position;
      if (to_camera.normalized().dot(point.position) > 0.3) point.views.push_back(v);
    }
    scene.points.push_back(point);
  }
  return scene;
}

StartOptions Sparse() {
  StartOptions options;
  options.points = StartPoints::kSparse;
  return options;
}

double Volume(const TriangleMesh& mesh) {
  double sum = 0;
  for (const Eigen::Vector3i& face : mesh.faces) {
    sum += mesh.vertices[face[0]].dot(mesh.vertices[face[1]].cross(mesh.vertices[face[2]])) / 6;
  }
  return sum;
}

TEST(StartMesh, OfASphereIsTheSphere) {
  const StartMesh start = MakeStartMesh(SphereScene(3000, 20), Sparse());
  const MeshReport report = CheckMesh(start.mesh);
  EXPECT_EQ(report.vertex_count, 3000);
  EXPECT_EQ(report.face_count, 2 * 3000 - 4);  // Euler, genus 0
  EXPECT_EQ(report.boundary_edge_count, 0);
  EXPECT_EQ(report.component_count, 1);
  EXPECT_EQ(start.lost_lines, 0);
  EXPECT_NEAR(Volume(start.mesh), 4 * M_PI / 3, 0.01);  // positive: outward
}

TEST(StartMesh, TakesTracksOfTwoViewsWhenAskedTo) {
  StartOptions options = Sparse();
  const Scene scene = SphereScene(3000, 2);
  try {
    MakeStartMesh(scene, options);
    FAIL() << "nothing was thrown";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("3000 that too few views see (start.min_views)"));
  }
  options.min_views = 2;
  const StartMesh start = MakeStartMesh(scene, options);
  EXPECT_NEAR(Volume(start.mesh), 4 * M_PI / 3, 0.02);
}

// A tenth of the points anywhere, inside the sphere and outside of it, each said to be seen by three views.
TEST(StartMesh, GrossOutliersLeaveTheSphere) {
  Scene scene = SphereScene(3000, 20);
  const std::vector<Vector3d> anywhere = RandomPoints(300, 7);
  for (int p = 0; p < 300; ++p) {
    ScenePoint point;
    point.position = 3 * anywhere[p] - Vector3d::Constant(1.5);
    for (const int v : {p % 18, p % 18 + 1, p % 18 + 2}) point.views.push_back(v);
    scene.points.push_back(point);
  }
  const StartMesh start = MakeStartMesh(scene, Sparse());
  int off = 0;
  for (const Vector3d& vertex : start.mesh.vertices) {
    off += std::abs(vertex.norm() - 1) > 0.05 ? 1 : 0;
  }
  EXPECT_LE(off, 3);
  EXPECT_NEAR(Volume(start.mesh), 4 * M_PI / 3, 0.05);
  EXPECT_EQ(CheckMesh(start.mesh).nonmanifold_edge_count, 0);
}

TEST(StartMesh, IsTheSameForAnyNumberOfThreads) {
  const Scene scene = SphereScene(2000, 20);
  std::vector<StartMesh> starts;
  for (const int count : {1, 4}) {
    const ThreadScope threads(count);
    starts.push_back(MakeStartMesh(scene, Sparse()));
  }
  EXPECT_EQ(starts[0].mesh.vertices, starts[1].mesh.vertices);
  EXPECT_EQ(starts[0].mesh.faces, starts[1].mesh.faces);
}

TEST(StartMesh, SaysWhatThePointsLack) {
  Scene scene = SphereScene(100, 20);
  for (ScenePoint& point : scene.points) point.views.clear();
  EXPECT_THROW(MakeStartMesh(scene, Sparse()), InputError);
  scene.points.clear();
  EXPECT_THROW(MakeStartMesh(scene, Sparse()), InputError);
}

TEST(StartMesh, LeavesOutPointsFarFromTheirMeasurements) {
  Scene scene = SphereScene(100, 20);
  for (size_t p = 0; p < scene.points.size(); ++p) {
    scene.tracks.BeginPoint();
    for (const int v : scene.points[p].views) {
      const Eigen::Vector2d there = scene.views[v].camera.Project(scene.points[p].position);
      scene.tracks.Add({there + Eigen::Vector2d(p < 10 ? 3 : 1, 0), v});
    }
  }
  SparseReport report;
  EXPECT_EQ(SparsePoints(scene, {}, &report).Count(), 90);
  EXPECT_EQ(report.large_error, 10);
}

}  // namespace
}  // namespace burin
