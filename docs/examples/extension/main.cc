// Your own cost term, choice of camera pairs and solver strategy on an installed burin, without changing
// burin: extension SCENE MESH OUTPUT.
#include <ceres/autodiff_cost_function.h>

#include <cmath>
#include <cstdio>
#include <exception>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "apps/run/pipeline.h"
#include "core/mesh/mesh_io.h"
#include "core/scene/formats/scene_loader.h"
#include "core/solve/normal_equations.h"

namespace {

// A cost term: every vertex is drawn to the plane z = `plane`, by the square of its distance. Positions
// are in the round's normalised world, whose unit is a pixel footprint.
struct ToPlane {
  ToPlane(double weight, double plane) : weight(weight), plane(plane) {}
  template <typename T>
  bool operator()(const T* vertex, T* residual) const {
    residual[0] = weight * (vertex[2] - plane);
    return true;
  }
  double weight;
  double plane;
};

// The term in one round. What is frozen: the mean height, so that the term flattens.
class PlaneRound : public burin::TermRound {
 public:
  PlaneRound(double weight, const burin::RoundContext& context)
      : weight_(weight), context_(context) {
    for (const Eigen::Vector3d& vertex : context.mesh->vertices) plane_ += vertex.z();
    plane_ /= static_cast<double>(context.mesh->vertices.size());
  }
  void AddBlocks(burin::RoundEnergy* energy) override {
    std::vector<Eigen::Vector3d>& vertices = energy->parameters().vertices;
    for (size_t v = 0; v < vertices.size(); ++v) {
      if (context_.supported[v] == 0) continue;
      energy->Add(std::make_unique<ceres::AutoDiffCostFunction<ToPlane, 1, 3>>(
                      new ToPlane(weight_, plane_)),
                  /*loss=*/nullptr, {vertices[v].data()});
    }
  }
  nlohmann::json Report() const override { return {{"plane", plane_}}; }

 private:
  const double weight_;
  const burin::RoundContext& context_;
  double plane_ = 0;
};

class PlaneTerm : public burin::EnergyTerm {
 public:
  explicit PlaneTerm(double weight) : weight_(weight) {}
  std::string Name() const override { return "plane"; }
  std::unique_ptr<burin::TermRound> Freeze(const burin::RoundContext& context) override {
    return std::make_unique<PlaneRound>(weight_, context);
  }

 private:
  const double weight_;
};

// A choice of pairs: every view with the one whose centre is nearest, both ways.
std::vector<burin::CameraPair> NearestPairs(const burin::Scene& scene) {
  std::vector<burin::CameraPair> pairs;
  const int count = static_cast<int>(scene.views.size());
  for (int i = 0; i < count; ++i) {
    int nearest = -1;
    double least = INFINITY;
    for (int j = 0; j < count; ++j) {
      const double distance =
          (scene.views[i].camera.Center() - scene.views[j].camera.Center()).norm();
      if (j == i || distance >= least) continue;
      least = distance;
      nearest = j;
    }
    pairs.push_back({i, nearest});
  }
  return pairs;
}

// A strategy: the diagonal of the Gauss-Newton matrix as step size, halved until the energy falls.
burin::SolveSummary SolveDiagonal(const burin::SolveTask& task,
                                  const burin::SolverOptions& options) {
  burin::NormalEquations equations(*task.energy, task.evaluation_callback);
  burin::SolveSummary summary;
  summary.unknowns = equations.unknowns();
  double energy = 0;
  Eigen::VectorXd gradient;
  if (!equations.Evaluate(&energy, &gradient)) return summary;  // usable stays false
  summary.usable = true;
  summary.initial_energy = energy;
  summary.termination = "Maximum number of iterations reached.";
  burin::NormalEquations::State state;
  for (int i = 1; i <= options.max_iterations; ++i) {
    equations.Save(&state);
    const Eigen::VectorXd diagonal = equations.matrix().Diagonal();
    const Eigen::VectorXd step =
        -gradient.array() / (diagonal.array() + 1e-6 * diagonal.maxCoeff());
    double share = 1;
    double trial = energy;
    while (share > 1e-4 && !(equations.SetPlus(state, share * step) &&
                             equations.EvaluateCost(&trial) && trial < energy)) {
      share /= 2;
    }
    if (share <= 1e-4) {
      equations.Restore(state);
      summary.termination = "No step lowers the energy.";
      break;
    }
    const double before = energy;
    equations.Evaluate(&energy, &gradient);
    summary.iterations = i;
    burin::IterationRecord record;
    record.iteration = i;
    record.energy = energy;
    if (task.on_iteration && !task.on_iteration(record)) break;
    if (before - energy <= options.function_tolerance * before) {
      summary.termination = "Function tolerance reached.";
      break;
    }
  }
  summary.final_energy = energy;
  return summary;
}

void Run(const char* scene_path, const char* mesh_path, const char* output) {
  burin::AddStrategy({"diagonal", "Gauss-Newton's diagonal, step halving", 0, SolveDiagonal});
  const burin::Scene scene = burin::LoadScene({scene_path, {}, {}});
  const burin::TriangleMesh mesh = burin::ReadMesh(mesh_path);
  burin::PipelineOptions options;
  options.refinement.solver.type = "diagonal";
  options.refinement.level.finest = 1;
  burin::PairSelection selection;
  selection.pairs = NearestPairs(scene);
  PlaneTerm plane(1e-3);
  burin::PipelineParts parts;
  parts.selection = &selection;
  parts.more_terms = {&plane};
  const burin::PipelineResult result = burin::RunPipeline(scene, mesh, options, parts);
  burin::WriteMesh(output, result.mesh);
  for (const burin::LevelSummary& level : result.refinement.levels) {
    const burin::RoundSummary& round = level.rounds.back();
    std::printf("level %d: %s, energy %.6g (plane %.3g)\n", level.level,
                round.solve.strategy.c_str(), round.energy_final["total"].get<double>(),
                round.energy_final["plane"].get<double>());
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: extension SCENE MESH OUTPUT.ply\n");
    return 2;
  }
  try {
    Run(argv[1], argv[2], argv[3]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "extension: error: %s\n", error.what());
    return 2;
  }
  return 0;
}
