// What the smoothness term asks of a vertex, and of one that keeps its shape.
#include "costs/smoothness_energy.h"

#include <gtest/gtest.h>

#include <memory>

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

}  // namespace
}  // namespace burin
