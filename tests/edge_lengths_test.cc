// Edge lengths against formulas: planes, cylinders, what is seen how.
#include "core/mesh/edge_lengths.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/remesh_shapes.h"
#include "tests/test_scene.h"

namespace burin {
namespace {

std::vector<double> Same(const TriangleMesh& mesh, double width) {
  return std::vector<double>(mesh.vertices.size(), width);
}

Camera Look(const Eigen::Vector3d& center) {
  return test::LookAt(center, {0.5, 0.5, 0}, 200, 200, 100);
}

TEST(EdgeLengths, PlanesGetTheLongest) {
  const TriangleMesh mesh = Plane(0, 10, 20);
  for (const double length : EdgeLengths(mesh, Same(mesh, 0.1), {})) EXPECT_NEAR(length, 0.7, 1e-9);
}

TEST(EdgeLengths, CylindersGetTheChordWithinBounds) {
  for (const double radius : {3.0, 20.0, 60.0, 500.0}) {
    SCOPED_TRACE(radius);
    const TriangleMesh mesh = Rod(radius, 12 * radius, 64, 120);
    const std::vector<double> curvature = MaxCurvatures(mesh, 3);
    EdgeLengthOptions options;
    options.chord_px = 0.12;
    options.max_px = 12;
    options.gradation = 1e9;  // each vertex for itself
    const std::vector<double> lengths = EdgeLengths(mesh, Same(mesh, 1), options);
    const double chord = std::sqrt(8 * options.chord_px * radius);
    const double turn = options.max_turn_deg * M_PI / 180 * radius;
    const double expected = std::min(std::min(std::max(chord, 4.0), 12.0), turn);
    for (size_t v = 0; v < mesh.vertices.size(); ++v) {
      if (std::abs(mesh.vertices[v].z() - 6 * radius) > 3 * radius) continue;  // near the caps
      EXPECT_NEAR(curvature[v] * radius, 1, 0.01);
      EXPECT_NEAR(lengths[v] / expected, 1, 0.01);
    }
  }
}

TEST(EdgeLengths, CurvatureOfANoisySphere) {
  TriangleMesh sphere = RoundSphere(10, 5);
  for (size_t v = 0; v < sphere.vertices.size(); ++v) sphere.vertices[v] *= v % 2 == 0 ? 1 : 1.006;
  const auto mean = [&](int rounds) {
    double sum = 0;
    for (const double curvature : MaxCurvatures(sphere, rounds)) sum += curvature;
    return sum / static_cast<double>(sphere.vertices.size());
  };
  EXPECT_GT(mean(0), 0.13);
  EXPECT_NEAR(mean(3), 0.1, 0.02);
}

TEST(EdgeLengths, GrowGradually) {
  const TriangleMesh mesh = Plane(0, 10, 20);
  std::vector<double> width = Same(mesh, 1);
  width[0] = 0.01;  // at the corner (0, 0)
  EdgeLengthOptions options;
  options.gradation = 0.3;
  const std::vector<double> lengths = EdgeLengths(mesh, width, options);
  EXPECT_NEAR(lengths[0], 0.07, 1e-9);
  for (int k = 0; k <= 20; ++k) EXPECT_NEAR(lengths[k], 0.07 + 0.3 * 0.5 * k, 1e-9);
  const Adjacency neighbors = VertexNeighbors(mesh, VertexFaces(mesh));
  for (int v = 0; v < static_cast<int>(lengths.size()); ++v) {
    for (const int* w = neighbors.Begin(v); w != neighbors.End(v); ++w) {
      EXPECT_LE(lengths[*w],
                lengths[v] + 0.3 * (mesh.vertices[*w] - mesh.vertices[v]).norm() + 1e-9);
    }
  }
}

TEST(PixelWidths, TheSharpestViewThatSeesIt) {
  const TriangleMesh mesh = Plane(0, 1, 4);
  const std::vector<Camera> cameras = {Look({0.5, 0.5, 10}), Look({0.5, 0.5, 5})};
  const auto footprint = [&](int i) { return cameras[i].Footprint(mesh.vertices[12]); };
  EXPECT_NEAR(PixelWidths(mesh, cameras, nullptr)[12], footprint(1), 1e-9);
  // Only the first sees it.
  std::vector<std::vector<char>> visible(mesh.faces.size(), {1, 0});
  EXPECT_NEAR(PixelWidths(mesh, cameras, &visible)[12], footprint(0), 1e-9);
  // A facet that nothing sees, far from what is seen: as its nearest seen neighbour, times the factor.
  for (std::vector<char>& of_facet : visible) of_facet = {0, 0};
  visible[0] = {1, 0};
  const std::vector<double> width = PixelWidths(mesh, cameras, &visible, 3);
  EXPECT_NEAR(width[24] / width[mesh.faces[0][2]], 3, 0.01);
  // None sees anything.
  visible[0] = {0, 0};
  for (const double w : PixelWidths(mesh, cameras, &visible)) EXPECT_EQ(w, 0);
}

TEST(PixelWidths, ObliqueViewsCountForLess) {
  const TriangleMesh mesh = Plane(0, 1, 4);
  const std::vector<Camera> cameras = {Look({0.5, 8.5, 8})};  // 45 degrees
  const double expected = cameras[0].Footprint(mesh.vertices[12]) / std::sqrt(std::sqrt(0.5));
  EXPECT_NEAR(PixelWidths(mesh, cameras, nullptr)[12], expected, 1e-9);
  const std::vector<Camera> flat = {Look({0.5, 8.5, 0.5})};
  const double bounded = flat[0].Footprint(mesh.vertices[12]) / std::sqrt(0.3);
  EXPECT_NEAR(PixelWidths(mesh, flat, nullptr)[12], bounded, 1e-9);
}

}  // namespace
}  // namespace burin
