// Truths of small meshes, and options to score against them, for the tests of scores.
#pragma once

#include <string>

#include "core/evaluate/evaluation.h"
#include "core/evaluate/truth.h"
#include "core/mesh/mesh.h"
#include "core/mesh/surface_samples.h"

namespace burin {

inline Truth MeshTruth(const TriangleMesh& mesh) {
  Truth truth;
  truth.mesh = mesh;
  return truth;
}

inline Truth CloudTruth(const TriangleMesh& mesh, int count, bool normals) {
  const SurfaceSamples samples = SampleSurface(mesh, count, 99);
  Truth truth;
  truth.cloud.points = samples.points;
  if (normals) truth.cloud.normals = samples.normals;
  return truth;
}

inline EvaluationOptions Options(const std::string& tau, int samples = 20000) {
  EvaluationOptions options;
  options.tau = tau;
  options.unit = 1;
  options.sample_count = samples;
  return options;
}

}  // namespace burin
