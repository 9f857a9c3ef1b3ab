// The paper's minimiser: gradient steps of one length and umbrella steps.
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "core/solve/ceres_problem.h"
#include "core/solve/strategies.h"
#include "core/support/stopwatch.h"

namespace burin {
namespace {

constexpr double kCameraShare = 0.25;  // of a Newton step

}  // namespace

// The paper's minimiser: V <- V - step * dE_photo/dV, then V <- V + umbrella_step * (neighbours'
// mean - V). The step is fixed for the round so that the 99th percentile of the first move is
// gradient_step_px footprints. Smoothness residuals of the problem are not used: the umbrella step
// stands for them; records have their energy in, to be compared with those of other strategies.
//
// A camera that moves takes a quarter of the Newton step by its own curvature, that of the round's start
// (core/solve/camera_units.h): the curvature of surface and cameras together is at most twice that of both alone, and of all cameras,
// a sum over pairs, at most twice that of each alone.
SolveSummary SolveGradientDescent(const SolveTask& task, const SolverOptions& options) {
  const Stopwatch watch;
  std::optional<CameraUnits> units;  // outlive the problem
  CeresProblem problem(*task.energy, task.evaluation_callback);
  std::vector<Eigen::Vector3d>& vertices = *task.vertices;
  std::vector<CameraPose>& cameras = task.energy->parameters().cameras;
  ceres::Problem::EvaluateOptions evaluate;
  evaluate.residual_blocks =
      problem.ResidualBlocks([](const std::string& term) { return term != "smoothness"; });
  std::vector<int> moving;
  std::vector<int> moving_cameras;
  for (const int parameter : task.energy->Moving()) {
    double* values = task.energy->Values(parameter);
    if (!problem->HasParameterBlock(values)) continue;
    if (task.energy->IsCamera(parameter)) {
      moving_cameras.push_back(parameter - task.energy->FirstCamera());
    } else if (parameter < static_cast<int>(vertices.size())) {
      moving.push_back(parameter);
    } else {
      continue;  // a term's own
    }
    evaluate.parameter_blocks.push_back(values);
  }
  int camera_unknowns = 0;
  if (!moving_cameras.empty()) {
    units.emplace(*task.energy, task.evaluation_callback, options.camera_damping);
    problem.MoveCamerasIn(*units);
    for (const int c : moving_cameras) camera_unknowns += units->Of(c)->TangentSize();
  }
  std::vector<size_t> first;  // unknown of each vertex
  size_t unknowns = 0;
  for (const int v : moving) {
    first.push_back(unknowns);
    unknowns += task.context->Unknowns(v);
  }
  SolveSummary summary;
  summary.unknowns = static_cast<int>(unknowns) + camera_unknowns;
  summary.termination = "Maximum number of iterations reached.";
  std::vector<Eigen::Vector3d> best = vertices;
  std::vector<CameraPose> best_cameras = cameras;
  double step = 0;
  std::vector<double> gradient;
  for (int iteration = 0;; ++iteration) {
    double energy = 0;
    if (!problem->Evaluate(evaluate, &energy, nullptr, &gradient, nullptr) ||
        !std::isfinite(energy)) {
      summary.termination = "Evaluation failed.";
      break;
    }
    if (iteration == 0) summary.initial_energy = energy;
    if (iteration == 0 || energy < summary.final_energy) {
      summary.final_energy = energy;
      best = vertices;
      best_cameras = cameras;
    }
    summary.usable = true;
    summary.iterations = iteration;
    std::vector<double> magnitude(moving.size());
    for (size_t m = 0; m < moving.size(); ++m) {
      magnitude[m] = task.context->MovesAlongNormal(moving[m])
                         ? std::abs(gradient[first[m]])
                         : Eigen::Map<const Eigen::Vector3d>(&gradient[first[m]]).norm();
    }
    IterationRecord record;
    record.iteration = iteration;
    record.energy = energy + task.energy->EnergyOf("smoothness");
    for (double m : magnitude) record.gradient_max = std::max(record.gradient_max, m);
    if (iteration == 0 && !magnitude.empty()) {
      const size_t rank = magnitude.size() * 99 / 100;
      std::nth_element(magnitude.begin(), magnitude.begin() + static_cast<long>(rank),
                       magnitude.end());
      step = magnitude[rank] > 0 ? options.gradient_step_px / magnitude[rank] : 0;
    }
    record.seconds = watch.Seconds();
    if (task.on_iteration && !task.on_iteration(record)) {
      summary.termination = "Stopped by the caller.";
      break;
    }
    if (iteration >= options.max_iterations) break;
    for (size_t m = 0; m < moving.size(); ++m) {
      const int v = moving[m];
      if (task.context->MovesAlongNormal(v)) {
        vertices[v] -= step * gradient[first[m]] * task.context->normals[v];
      } else {
        vertices[v] -= step * Eigen::Map<const Eigen::Vector3d>(&gradient[first[m]]);
      }
    }
    const double* of_camera = gradient.data() + unknowns;
    for (const int c : moving_cameras) {
      const ceres::Manifold& motion = *units->Of(c);
      const Eigen::VectorXd move =
          -kCameraShare / units->curvature() *
          Eigen::Map<const Eigen::VectorXd>(of_camera, motion.TangentSize());
      const CameraPose from = cameras[c];
      motion.Plus(from.data(), move.data(), cameras[c].data());
      of_camera += motion.TangentSize();
    }
    const std::vector<Eigen::Vector3d> before = vertices;
    const Adjacency& neighbors = task.context->neighbors;
    for (int v : moving) {
      if (task.context->boundary[v] != 0) continue;
      Eigen::Vector3d mean = Eigen::Vector3d::Zero();
      for (const int* n = neighbors.Begin(v); n != neighbors.End(v); ++n) mean += before[*n];
      Eigen::Vector3d move = options.umbrella_step * (mean / neighbors.Degree(v) - before[v]);
      if (task.context->MovesAlongNormal(v)) {
        move = task.context->normals[v] * task.context->normals[v].dot(move);
      }
      vertices[v] += move;
    }
  }
  std::copy(best.begin(), best.end(), vertices.begin());  // the addresses are the problem's
  std::copy(best_cameras.begin(), best_cameras.end(), cameras.begin());
  return summary;
}

}  // namespace burin
