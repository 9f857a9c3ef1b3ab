// What the smoothness term asks of a vertex, and of one that keeps its shape.
#include "costs/smoothness_energy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <utility>
#include <vector>

#include "core/mesh/remesh.h"
#include "core/solve/ceres_problem.h"
#include "tests/test_scene.h"

namespace burin {
namespace {

constexpr int kMiddle = 3 * 7 + 3;

// A grid of 7 x 7 vertices with one of them lifted.
struct Spike {
  Spike() {
    test::AppendGrid(&mesh, 6, 0, 0, 1.0, [](double, double) { return 0.0; });
    mesh.vertices[kMiddle].z() += 0.3;
    context.mesh = &mesh;
    context.neighbors = VertexNeighbors(mesh, VertexFaces(mesh));
    context.faces = VertexFaces(mesh);
    context.boundary = BoundaryVertices(mesh, VertexFaces(mesh));
    context.normals = VertexNormals(mesh, VertexFaces(mesh));
    context.keeps_shape.assign(mesh.vertices.size(), 0);
  }
  // Energy and its derivative by the height of the lifted vertex.
  double Evaluate(double* slope) {
    SmoothnessEnergy energy((SmoothnessOptions()));
    RoundParameters parameters{mesh.vertices};
    RoundEnergy sum(&parameters);
    const std::unique_ptr<TermRound> round = energy.Freeze(context);
    round->AddBlocks(&sum);
    round->SupportIsKnown();
    const CeresProblem problem(sum, nullptr);
    ceres::Problem::EvaluateOptions evaluate;
    evaluate.parameter_blocks = {parameters.vertices[kMiddle].data()};
    double value = 0;
    std::vector<double> gradient;
    problem->Evaluate(evaluate, &value, nullptr, &gradient, nullptr);
    *slope = gradient[2];
    return value;
  }
  TriangleMesh mesh;
  RoundContext context;
};

TEST(SmoothnessEnergy, ASpikeIsFlattened) {
  Spike spike;
  double slope = 0;
  EXPECT_GT(spike.Evaluate(&slope), 0.1);
  EXPECT_GT(slope, 1);
}

TEST(SmoothnessEnergy, WhatKeepsItsShapeIsNot) {
  Spike spike;
  spike.context.keeps_shape.assign(spike.mesh.vertices.size(), 1);
  double slope = 0;
  EXPECT_NEAR(spike.Evaluate(&slope), 0, 1e-20);
  EXPECT_NEAR(slope, 0, 1e-12);
}

// sin^2 waves of this height over a square of this side, as displacements out of it.
constexpr double kSide = 64;
constexpr double kHeight = 0.5;

double Wave(const Eigen::Vector3d& at) {
  const auto one = [](double t) { return std::pow(std::sin(M_PI * t / kSide), 2); };
  return kHeight * one(at.x()) * one(at.y());
}

// E_smooth of the waves on a mesh of the square, of its closed form: weight/32 times the integral of |Laplace(w)|^2, which is
// 2 (height pi^2 / side)^2.
double ShareOfClosedForm(const TriangleMesh& flat) {
  RoundContext context;
  context.mesh = &flat;
  context.faces = VertexFaces(flat);
  context.neighbors = VertexNeighbors(flat, context.faces);
  context.boundary = BoundaryVertices(flat, context.faces);
  context.keeps_shape.assign(flat.vertices.size(), 1);  // what is left is of displacements only
  const SmoothnessOptions options;
  SmoothnessEnergy energy(options);
  RoundParameters parameters{flat.vertices};
  RoundEnergy sum(&parameters);
  const std::unique_ptr<TermRound> round = energy.Freeze(context);
  round->AddBlocks(&sum);
  round->SupportIsKnown();
  for (Eigen::Vector3d& vertex : parameters.vertices) vertex.z() += Wave(vertex);
  const CeresProblem problem(sum, nullptr);
  double value = 0;
  problem->Evaluate(ceres::Problem::EvaluateOptions(), &value, nullptr, nullptr, nullptr);
  return value / (options.weight / 32 * 2 * std::pow(kHeight * M_PI * M_PI / kSide, 2));
}

TriangleMesh Square(int cells) {
  TriangleMesh mesh;
  test::AppendGrid(&mesh, cells, kSide / 2, kSide / 2, kSide / 2,
                   [](double, double) { return 0.0; });
  return mesh;
}

// The square with edges that are `small` long in its middle and longer by `slope` times the way from there.
TriangleMesh Adapted(double small, double slope) {
  const TriangleMesh fine = Square(64);
  std::vector<double> lengths;
  for (const Eigen::Vector3d& at : fine.vertices) {
    const double way = (at - Eigen::Vector3d(kSide / 2, kSide / 2, 0)).norm();
    lengths.push_back(small + slope * std::max(0.0, way - 6));
  }
  return Remesh(fine, lengths, RemeshOptions()).mesh;
}

TEST(SmoothnessEnergy, WeighsTheSameOnCoarseFineUniformAndAdaptedMeshes) {
  const std::pair<const char*, TriangleMesh> meshes[] = {
      {"grid, coarse", Square(16)},       {"grid, fine", Square(48)},
      {"uniform, coarse", Adapted(4, 0)}, {"uniform, fine", Adapted(1.5, 0)},
      {"adapted", Adapted(1.5, 0.15)},    {"adapted, steep", Adapted(1.5, 0.4)},
  };
  for (const auto& [name, mesh] : meshes) {
    const double share = ShareOfClosedForm(mesh);
    std::printf("%-16s %6zu facets: %.3f\n", name, mesh.faces.size(), share);
    EXPECT_GT(share, 1.0) << name;
    EXPECT_LT(share, 1.6) << name;
  }
}

}  // namespace
}  // namespace burin
