#include "core/mesh/subdivide.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <set>

#include "core/mesh/mesh_check.h"
#include "core/mesh/mesh_io.h"
#include "core/mesh/projected_area.h"
#include "core/support/parallel.h"

namespace burin {
namespace {

// Looks from `center` at `target`, 200 x 100 px, focal length 100 px.
Camera LookAt(const Eigen::Vector3d& center, const Eigen::Vector3d& target) {
  const Eigen::Vector3d forward = (target - center).normalized();
  const Eigen::Vector3d right =
      forward
          .cross(std::abs(forward.z()) < 0.9 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitY())
          .normalized();
  Camera camera;
  camera.width = 200;
  camera.height = 100;
  camera.fx = camera.fy = 100;
  camera.cx = 100;
  camera.cy = 50;
  camera.rotation.row(0) = right;
  camera.rotation.row(1) = forward.cross(right);
  camera.rotation.row(2) = forward;
  camera.translation = -camera.rotation * center;
  return camera;
}

TriangleMesh Square() {  // [0,1]^2 in z = 0, normal +z
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.faces = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

TriangleMesh Octahedron() {
  TriangleMesh mesh;
  mesh.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.faces = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  return mesh;
}

// Irregular, curved and open: a jittered grid over [-1,1]^2 with n x n cells.
TriangleMesh Relief(int n) {
  TriangleMesh mesh;
  std::uint32_t state = 7;
  const auto jitter = [&] {
    state = state * 1664525U + 1013904223U;
    return 0.5 * ((state >> 8) / 16777216.0 - 0.5);
  };
  for (int row = 0; row <= n; ++row) {
    for (int col = 0; col <= n; ++col) {
      const double x = 2 * (col + jitter()) / n - 1;
      const double y = 2 * (row + jitter()) / n - 1;
      mesh.vertices.emplace_back(x, y, 0.2 * std::sin(3 * x) * std::cos(2 * y));
    }
  }
  for (int row = 0; row < n; ++row) {
    for (int col = 0; col < n; ++col) {
      const int v = row * (n + 1) + col;
      mesh.faces.push_back({v, v + 1, v + n + 2});
      mesh.faces.push_back({v, v + n + 2, v + n + 1});
    }
  }
  return mesh;
}

double SmallestAngleDeg(const TriangleMesh& mesh) {
  double smallest = 180;
  for (const Eigen::Vector3i& face : mesh.faces) {
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector3d u = mesh.vertices[face[(c + 1) % 3]] - mesh.vertices[face[c]];
      const Eigen::Vector3d v = mesh.vertices[face[(c + 2) % 3]] - mesh.vertices[face[c]];
      smallest = std::min(smallest, std::atan2(u.cross(v).norm(), u.dot(v)) * 180 / M_PI);
    }
  }
  return smallest;
}

// V - E + F, each face counted once and those that repeat a vertex not at all.
int EulerCharacteristic(const TriangleMesh& mesh) {
  std::set<std::pair<int, int>> edges;
  std::set<std::set<int>> faces;
  for (const Eigen::Vector3i& face : mesh.faces) {
    const std::set<int> corners = {face[0], face[1], face[2]};
    if (corners.size() < 3) continue;
    faces.insert(corners);
    for (int c = 0; c < 3; ++c) edges.insert(std::minmax({face[c], face[(c + 1) % 3]}));
  }
  return static_cast<int>(mesh.vertices.size()) - static_cast<int>(edges.size()) +
         static_cast<int>(faces.size());
}

// What holds for every split, whatever the input.
void ExpectSameSurface(const TriangleMesh& before, const TriangleMesh& after,
                       const SubdivisionReport& report) {
  const size_t old_count = before.vertices.size();
  ASSERT_EQ(report.new_vertex_parents.size(), after.vertices.size() - old_count);
  ASSERT_EQ(report.new_vertex_count, static_cast<int>(after.vertices.size() - old_count));
  ASSERT_EQ(report.face_origin.size(), after.faces.size());
  ASSERT_EQ(report.face_count, static_cast<int>(after.faces.size()));
  for (size_t v = 0; v < old_count; ++v) EXPECT_EQ(after.vertices[v], before.vertices[v]);
  for (size_t k = 0; k < report.new_vertex_parents.size(); ++k) {
    const auto [a, b] = report.new_vertex_parents[k];
    ASSERT_LT(std::max(a, b), static_cast<int>(old_count + k));
    EXPECT_EQ(after.vertices[old_count + k], 0.5 * (after.vertices[a] + after.vertices[b]));
  }
  // Every part lies in its input face, keeps its orientation, and the parts add up to the face.
  std::vector<double> area(before.faces.size(), 0);
  for (size_t f = 0; f < after.faces.size(); ++f) {
    const int origin = report.face_origin[f];
    const Eigen::Vector3d part = FaceAreaNormal(after, static_cast<int>(f));
    const Eigen::Vector3d whole = FaceAreaNormal(before, origin);
    EXPECT_GE(part.dot(whole), 0);
    area[origin] += part.norm();
    const Eigen::Vector3i& face = before.faces[origin];
    const Eigen::Vector3d& corner = before.vertices[face[0]];
    Eigen::Matrix<double, 3, 2> sides;
    sides << before.vertices[face[1]] - corner, before.vertices[face[2]] - corner;
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector3d offset = after.vertices[after.faces[f][c]] - corner;
      const Eigen::Vector2d weights = sides.colPivHouseholderQr().solve(offset);
      EXPECT_LT((sides * weights - offset).norm(), 1e-12);
      EXPECT_GT(weights.minCoeff(), -1e-9);
      EXPECT_LT(weights.sum(), 1 + 1e-9);
    }
  }
  for (size_t f = 0; f < before.faces.size(); ++f) {
    const double whole = FaceAreaNormal(before, static_cast<int>(f)).norm();
    EXPECT_NEAR(area[f], whole, 1e-12 * std::max(1.0, whole));
  }
}

void ExpectBound(const TriangleMesh& mesh, const std::vector<Camera>& cameras, double bound) {
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    EXPECT_LE(SharpestArea(mesh, static_cast<int>(f), cameras), bound * (1 + 1e-9)) << f;
  }
}

TEST(ProjectedArea, ClosedForms) {
  const Camera camera = LookAt({0, 0, 10}, {0, 0, 0});  // 10 px per unit in z = 0, sees 20 x 10
  const auto area = [&](Eigen::Vector3d a, Eigen::Vector3d b, Eigen::Vector3d c) {
    return ProjectedArea(camera, a, b, c);
  };
  EXPECT_NEAR(area({0, 0, 0}, {1, 0, 0}, {0, 2, 0}), 100, 1e-9);
  EXPECT_NEAR(area({0, 2, 0}, {1, 0, 0}, {0, 0, 0}), 100, 1e-9);    // either orientation
  EXPECT_NEAR(area({0, 0, 0}, {20, 0, 0}, {0, 0.1, 0}), 75, 1e-9);  // the far quarter is outside
  EXPECT_NEAR(area({-99, -99, 0}, {99, -99, 0}, {0, 999, 0}), 20000, 1e-6);  // the whole image
  EXPECT_EQ(area({11, 0, 0}, {12, 0, 0}, {11, 1, 0}), 0);
  EXPECT_EQ(area({0, 0, 11}, {1, 0, 11}, {0, 1, 11}), 0);  // behind
  EXPECT_EQ(area({0, 0, 10}, {1, 0, 0}, {0, 1, 0}), 0);    // through the centre
  // A road from below the camera to the horizon, reaching behind it: x in [-1,1] at y = -1, image
  // columns 100 -+ 100/z at rows 50 + 100/z: the wedge from (100, 50) to (50..150, 100).
  const Camera driver = LookAt({0, 0, 1}, {0, 9, 1});
  const double road = ProjectedArea(driver, {-1, -5, 0}, {1, -5, 0}, {1, 1e6, 0}) +
                      ProjectedArea(driver, {-1, -5, 0}, {1, 1e6, 0}, {-1, 1e6, 0});
  EXPECT_NEAR(road, 0.5 * 50 * 100, 0.1);
}

TEST(SplitLargeFaces, SquareIsSplitToTheBoundAndNoFurther) {
  // 1000 px^2 over the square; halves of 500, 250, ..., 15.6 px^2 are the first within 16.
  const Camera camera = LookAt({0.5, 0.5, std::sqrt(10.0)}, {0.5, 0.5, 0});
  TriangleMesh mesh = Square();
  const SubdivisionReport report = SplitLargeFaces(&mesh, {camera}, {});
  EXPECT_TRUE(report.reached_bound);
  EXPECT_EQ(mesh.faces.size(), 64U);
  ExpectBound(mesh, {camera}, 16);
  ExpectSameSurface(Square(), mesh, report);
  EXPECT_NEAR(SmallestAngleDeg(mesh), 45, 1e-9);
  EXPECT_EQ(EulerCharacteristic(mesh), 1);
  EXPECT_EQ(CheckMesh(mesh).boundary_edge_count, 16);
}

TEST(SplitLargeFaces, ClosedSurfaceStaysClosedAndOnlyTheSeenSideIsSplit) {
  const Camera camera = LookAt({0, 0, 5}, {0, 0, 0});
  TriangleMesh mesh = Octahedron();
  SubdivisionOptions options;
  options.max_facet_px = 2;
  const SubdivisionReport report = SplitLargeFaces(&mesh, {camera}, options);
  ExpectBound(mesh, {camera}, 2);
  ExpectSameSurface(Octahedron(), mesh, report);
  const MeshReport check = CheckMesh(mesh);
  EXPECT_EQ(EulerCharacteristic(mesh), 2);
  EXPECT_EQ(check.boundary_edge_count + check.nonmanifold_edge_count +
                check.inconsistent_edge_count + check.duplicate_vertex_count,
            0);
  int seen = 0;
  for (int origin : report.face_origin) seen += origin < 4;
  EXPECT_GT(seen, 2 * (report.face_count - seen));  // the back follows only near the rim
  EXPECT_GT(report.face_count, 400);
}

TEST(SplitLargeFaces, IrregularMeshSeveralViews) {
  const std::vector<Camera> cameras = {LookAt({0, 0, 3}, {0, 0, 0}), LookAt({2, 1, 2}, {0, 0, 0}),
                                       LookAt({-0.8, -0.8, 0.5}, {-0.9, -0.9, 0})};
  const TriangleMesh before = Relief(12);
  TriangleMesh mesh = before;
  const SubdivisionReport report = SplitLargeFaces(&mesh, cameras, {});
  EXPECT_TRUE(report.reached_bound);
  EXPECT_GT(report.face_count, 4 * report.input_face_count);
  ExpectBound(mesh, cameras, 16);
  ExpectSameSurface(before, mesh, report);
  EXPECT_EQ(EulerCharacteristic(mesh), 1);
  EXPECT_EQ(CheckMesh(mesh).nonmanifold_edge_count, 0);
  EXPECT_EQ(CheckMesh(mesh).inconsistent_edge_count, 0);
  const double before_deg = SmallestAngleDeg(before);
  const double after_deg = SmallestAngleDeg(mesh);
  RecordProperty("smallest_angle_before_deg", std::to_string(before_deg));
  RecordProperty("smallest_angle_after_deg", std::to_string(after_deg));
  EXPECT_GE(after_deg, 0.5 * before_deg);
  // No face is cut much finer than it must be: most are within a factor of four of the bound.
  int needlessly_small = 0;
  for (int f = 0; f < report.face_count; ++f) {
    needlessly_small += SharpestArea(mesh, f, cameras) < 4;
  }
  EXPECT_LT(needlessly_small, report.face_count / 4);
}

TEST(SplitLargeFaces, NothingToDoLeavesTheMeshAsItIs) {
  const TriangleMesh before = Relief(4);
  for (const std::vector<Camera>& cameras :
       {std::vector<Camera>{}, {LookAt({0, 0, -3}, {0, 0, 0})}, {LookAt({0, 0, 3}, {0, 0, 9})}}) {
    TriangleMesh mesh = before;
    const SubdivisionReport report = SplitLargeFaces(&mesh, cameras, {});
    EXPECT_TRUE(report.reached_bound);
    EXPECT_EQ(mesh.faces, before.faces);
    EXPECT_EQ(mesh.vertices, before.vertices);
    ExpectSameSurface(before, mesh, report);
  }
}

TEST(SplitLargeFaces, LongFacesSeenObliquelyAreSplitByTheirEdges) {
  // Nearly edge-on: the square covers about 23 px^2, its halves are within 16; but it is 25 to 33
  // pixel footprints long. Halves have hypotenuses of 1.41, 1, 0.71, 0.5, 0.35; at the far side, 4
  // away, 12 footprints are 0.48.
  const Camera camera = LookAt({0.5, -3, 0.1}, {0.5, 0.5, 0});
  TriangleMesh mesh = Square();
  SplitLargeFaces(&mesh, {camera}, {});
  EXPECT_EQ(mesh.faces.size(), 2U);
  SubdivisionOptions options;
  options.max_edge_px = 12;
  const SubdivisionReport report = SplitLargeFaces(&mesh, {camera}, options);
  EXPECT_TRUE(report.reached_bound);
  EXPECT_EQ(mesh.faces.size(), 32U);
  EXPECT_NEAR(SmallestAngleDeg(mesh), 45, 1e-9);
  ExpectSameSurface(Square(), mesh, report);
  EXPECT_EQ(EulerCharacteristic(mesh), 1);
  // What no view has inside is left alone, however long: here all lies behind the camera.
  TriangleMesh behind = Square();
  SplitLargeFaces(&behind, {LookAt({0.5, -3, 0.1}, {0.5, -9, 0})}, options);
  EXPECT_EQ(behind.faces.size(), 2U);
}

TEST(SplitLargeFaces, OnlyViewsWhereTheInputFaceIsVisibleCount) {
  const std::vector<Camera> cameras = {LookAt({0, 0, 3}, {0, 0, 0}), LookAt({0, 0, 9}, {0, 0, 0})};
  const TriangleMesh before = Relief(6);
  std::vector<std::vector<char>> visible(before.faces.size(), {0, 1});  // only the far camera
  TriangleMesh masked = before;
  SplitLargeFaces(&masked, cameras, {}, &visible);
  TriangleMesh far = before;
  SplitLargeFaces(&far, {cameras[1]}, {});
  EXPECT_EQ(masked.faces, far.faces);
  TriangleMesh near = before;
  SplitLargeFaces(&near, cameras, {});
  EXPECT_GT(near.faces.size(), 2 * far.faces.size());
}

TEST(SplitLargeFaces, SameBytesForAnyThreadCount) {
  const std::vector<Camera> cameras = {LookAt({0, 0, 1}, {0, 0, 0}), LookAt({2, 1, 1}, {0, 0, 0})};
  TriangleMesh one = Relief(12);
  TriangleMesh two = one;
  const ThreadScope one_thread(1);
  SplitLargeFaces(&one, cameras, {});
  const ThreadScope all_cores(0);
  SplitLargeFaces(&two, cameras, {});
  EXPECT_EQ(one.faces, two.faces);
  EXPECT_EQ(one.vertices, two.vertices);
}

TEST(SplitLargeFaces, NonManifoldEdgesAreSplitInAllTheirFaces) {
  // Three sheets around the z axis of different widths, two octahedra that touch at a point, a face
  // twice, a neighbour turned over, a face that repeats a vertex, a zero-area face.
  TriangleMesh before;
  before.vertices = {{0, 0, -1}, {0, 0, 1}, {3, 0.1, 0}, {-1, 2, 0}, {-1, -0.3, 0}};
  before.faces = {{0, 2, 1}, {0, 3, 1}, {1, 4, 0}, {0, 2, 1}, {2, 2, 3}};
  for (int copy = 0; copy < 2; ++copy) {
    const auto base = static_cast<int>(before.vertices.size());
    const TriangleMesh octahedron = Octahedron();
    for (const auto& v : octahedron.vertices) {
      before.vertices.push_back(v + Eigen::Vector3d(2 * copy - 1, 0, 4));
    }
    for (Eigen::Vector3i face : octahedron.faces) {
      for (int c = 0; c < 3; ++c) {
        // Vertex 1 of the second is vertex 0 of the first.
        face[c] = copy == 1 && face[c] == 1 ? 5 : face[c] + base;
      }
      before.faces.push_back(face);
    }
  }
  before.vertices.emplace_back(0, 0, 1);
  before.faces.push_back({0, 1, static_cast<int>(before.vertices.size()) - 1});
  const std::vector<Camera> cameras = {LookAt({1, 5, 3}, {0, 0, 1}), LookAt({1, -5, 3}, {0, 0, 1}),
                                       LookAt({6, 0, 1}, {0, 0, 1})};
  TriangleMesh mesh = before;
  const SubdivisionReport report = SplitLargeFaces(&mesh, cameras, {});
  EXPECT_TRUE(report.reached_bound);
  EXPECT_GT(report.face_count, 200);
  EXPECT_EQ(report.kept_face_count, 1);
  EXPECT_GT(report.copied_vertex_count, 0);
  ExpectBound(mesh, cameras, 16);
  ExpectSameSurface(before, mesh, report);
  EXPECT_EQ(EulerCharacteristic(mesh), EulerCharacteristic(before));
  // The edge 0-1 of four faces is split into pieces of four faces each.
  std::map<std::pair<int, int>, int> uses;
  const auto on_axis = [&](int v) {
    return mesh.vertices[v].head<2>().isZero(0) && std::abs(mesh.vertices[v].z()) <= 1 &&
           v != static_cast<int>(before.vertices.size()) - 1;
  };
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    if (report.face_origin[f] > 3) continue;
    for (int c = 0; c < 3; ++c) {
      const int a = mesh.faces[f][c], b = mesh.faces[f][(c + 1) % 3];
      if (on_axis(a) && on_axis(b)) ++uses[std::minmax({a, b})];
    }
  }
  EXPECT_GE(uses.size(), 4U);
  for (const auto& [edge, count] : uses) EXPECT_EQ(count, 4) << edge.first << " " << edge.second;
}

TEST(SplitLargeFaces, AnySoupOfTrianglesKeepsItsSurfaceAndConforms) {
  const std::vector<Camera> cameras = {LookAt({0, 0, 2.5}, {0, 0, 0}),
                                       LookAt({0, 0, -2.5}, {0, 0, 0})};
  SubdivisionOptions options;
  options.max_facet_px = 100;
  std::uint32_t state = 3;
  const auto random = [&](std::uint32_t below) {
    state = state * 1664525U + 1013904223U;
    return static_cast<int>((state >> 8) % below);
  };
  for (int trial = 0; trial < 60; ++trial) {
    TriangleMesh before;
    for (int v = 0; v < 8; ++v) {
      before.vertices.emplace_back(random(1000) / 500.0 - 1, random(1000) / 500.0 - 1,
                                   random(1000) / 500.0 - 1);
    }
    for (int f = 0; f < 20; ++f) before.faces.push_back({random(8), random(8), random(8)});
    TriangleMesh mesh = before;
    const SubdivisionReport report = SplitLargeFaces(&mesh, cameras, options);
    EXPECT_TRUE(report.reached_bound);
    ExpectBound(mesh, cameras, 100);
    ExpectSameSurface(before, mesh, report);
    EXPECT_EQ(EulerCharacteristic(mesh), EulerCharacteristic(before));
    // No edge that was split is left whole in another face.
    std::set<std::pair<int, int>> split;
    for (const auto& [a, b] : report.new_vertex_parents) {
      EXPECT_TRUE(split.insert(std::minmax({a, b})).second);
    }
    for (const Eigen::Vector3i& face : mesh.faces) {
      for (int c = 0; c < 3 && std::set<int>{face[0], face[1], face[2]}.size() == 3; ++c) {
        EXPECT_EQ(split.count(std::minmax({face[c], face[(c + 1) % 3]})), 0U);
      }
    }
  }
}

TEST(SplitLargeFaces, StopsAtTheFaceCount) {
  SubdivisionOptions options;
  options.max_facet_px = 1e-3;
  options.max_face_count = 5000;
  TriangleMesh mesh = Relief(4);
  const SubdivisionReport report = SplitLargeFaces(&mesh, {LookAt({0, 0, 3}, {0, 0, 0})}, options);
  EXPECT_FALSE(report.reached_bound);
  EXPECT_LE(report.face_count, 5001);
  EXPECT_GE(report.face_count, 5000);
  ExpectSameSurface(Relief(4), mesh, report);
  EXPECT_EQ(EulerCharacteristic(mesh), 1);
}

TEST(SplitLargeFaces, PositionAndSizeOfTheSceneDoNotMatter) {
  // At UTM coordinates and a thousandth of the size: same faces, up to ties broken by rounding.
  const std::vector<Camera> cameras = {LookAt({0, 0, 1}, {0, 0, 0}), LookAt({2, 1, 1}, {0, 0, 0})};
  TriangleMesh here = Relief(8);
  TriangleMesh there = here;
  const Eigen::Vector3d origin(-512, 1024, 64);
  std::vector<Camera> moved;
  moved.reserve(cameras.size());
  for (const Camera& camera : cameras) moved.push_back(camera.InScaledWorld(origin, 1.0 / 1024));
  for (Eigen::Vector3d& v : there.vertices) v = (v - origin) / 1024;
  SplitLargeFaces(&here, cameras, {});
  SplitLargeFaces(&there, moved, {});
  EXPECT_EQ(here.faces, there.faces);
}

}  // namespace
}  // namespace burin
