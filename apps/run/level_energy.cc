#include "apps/run/level_energy.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "core/refine/frozen_round.h"
#include "core/refine/normalized_world.h"
#include "core/refine/round.h"
#include "core/scene/pyramid.h"
#include "core/solve/normal_equations.h"
#include "core/support/error.h"
#include "core/support/parallel.h"

namespace burin {
namespace {

void CheckLevel(const Scene& scene, int level, int window) {
  constexpr int kCoarsest = 11;  // as level.finest
  if (level < 0 || level > kCoarsest) {
    throw InputError("level = " + std::to_string(level) + ": must be in [0, " +
                     std::to_string(kCoarsest) + "]");
  }
  for (const View& view : scene.views) {
    if ((std::min(view.camera.width, view.camera.height) >> level) < window) {
      throw InputError("level = " + std::to_string(level) + ": photograph " + view.name +
                       " is smaller than the window there");
    }
  }
}

}  // namespace

struct LevelEnergy::Impl {
  Impl(const Scene& scene, const TriangleMesh& world, const std::vector<CameraPair>& pairs,
       const PipelineOptions& o, int level)
      : options(o), photometric(o.photo), smoothness(o.smooth) {
    options.Check();
    const ThreadScope threads(options.threads);
    CheckLevel(scene, level, options.photo.window);
    if (const std::string fault = PairsFault(pairs, scene); !fault.empty()) throw InputError(fault);
    normalized = NormalizedWorld::Of(scene, world);
    if (normalized.footprint <= 0) {
      throw InputError("no vertex of the mesh projects into any of the views");
    }
    mesh = normalized.FromWorld(world);
    views = MakeLevelViews(scene, level, normalized.origin, 1 / normalized.footprint);
    context = FreezeRound(views, pairs, mesh, options.refinement.motion,
                          options.refinement.level.border_px, &domains);
    int64_t pixels = 0;
    for (const ViewDomain& domain : domains) {
      for (const int64_t of_pair : domain.pair_pixels) pixels += of_pair;
    }
    if (pixels == 0) throw InputError("pairs: none of them sees a common part of the mesh");
    photometric.BeginLevel(views);
    terms.emplace(std::vector<EnergyTerm*>{&photometric, &smoothness}, context);
    parameters.vertices = mesh.vertices;
    round = std::make_unique<RoundProblem>(*terms, context, &parameters);
    round->SupportIsKnown();
    round->task.pixel = std::ldexp(1.0, level);
    equations =
        std::make_unique<NormalEquations>(*round->task.energy, round->task.evaluation_callback);
    equations->Save(&start);
    vertex_of_unknown.resize(equations->unknowns());
    for (const NormalEquations::MovingBlock& block : equations->moving_blocks()) {
      for (int k = 0; k < block.tangent_size; ++k) {
        vertex_of_unknown[block.first_unknown + k] = block.parameter;
      }
    }
  }

  void MoveTo(const Eigen::VectorXd& x) {
    if (x.size() != equations->unknowns()) {
      throw InputError("x: has " + std::to_string(x.size()) + " entries, must have " +
                       std::to_string(equations->unknowns()));
    }
    equations->SetPlus(start, x);
  }

  std::mutex mutex;  // held, by InUse, while a call uses what is below
  PipelineOptions options;
  PhotometricEnergy photometric;
  SmoothnessEnergy smoothness;
  NormalizedWorld normalized;
  TriangleMesh mesh;  // in it
  std::vector<LevelView> views;
  std::vector<ViewDomain> domains;
  RoundContext context;
  std::optional<TermRounds> terms;
  RoundParameters parameters;
  std::unique_ptr<RoundProblem> round;
  std::unique_ptr<NormalEquations> equations;
  NormalEquations::State start;
  std::vector<int> vertex_of_unknown;
};

// A call that uses what Impl holds, in the run's threads.
class LevelEnergy::InUse {
 public:
  explicit InUse(Impl* impl) : lock_(impl->mutex), threads_(impl->options.threads) {}

 private:
  const std::lock_guard<std::mutex> lock_;
  const ThreadScope threads_;
};

LevelEnergy::LevelEnergy(const Scene& scene, const TriangleMesh& mesh,
                         const std::vector<CameraPair>& pairs, const PipelineOptions& options,
                         int level)
    : impl_(std::make_unique<Impl>(scene, mesh, pairs, options, level)) {}

LevelEnergy::~LevelEnergy() = default;

int LevelEnergy::unknowns() const { return impl_->equations->unknowns(); }
double LevelEnergy::footprint() const { return impl_->normalized.footprint; }
const std::vector<int>& LevelEnergy::vertex_of_unknown() const { return impl_->vertex_of_unknown; }
const std::vector<Eigen::Vector3d>& LevelEnergy::normals() const { return impl_->context.normals; }

double LevelEnergy::Evaluate(const Eigen::VectorXd& x, Eigen::VectorXd* gradient) {
  const InUse in_use(impl_.get());
  impl_->MoveTo(x);
  double energy = 0;
  gradient->resize(unknowns());
  if (!impl_->equations->EvaluateGradient(&energy, gradient)) return std::nan("");
  return energy;
}

SymmetricMatrix LevelEnergy::Linearize(const Eigen::VectorXd& x, double* energy,
                                       Eigen::VectorXd* gradient) {
  const InUse in_use(impl_.get());
  impl_->MoveTo(x);
  gradient->resize(unknowns());
  if (!impl_->equations->Evaluate(energy, gradient)) *energy = std::nan("");
  return impl_->equations->matrix();
}

nlohmann::json LevelEnergy::Terms(const Eigen::VectorXd& x) {
  const InUse in_use(impl_.get());
  impl_->MoveTo(x);
  return impl_->round->EnergyByTerm();
}

std::vector<Eigen::Vector3d> LevelEnergy::VerticesAt(const Eigen::VectorXd& x) const {
  const InUse in_use(impl_.get());
  impl_->MoveTo(x);
  return impl_->normalized.ToWorld({impl_->parameters.vertices, {}}).vertices;
}

LevelEnergy::Solution LevelEnergy::Solve(const std::string& strategy) {
  const InUse in_use(impl_.get());
  const SolverOptions& solver = impl_->options.refinement.solver;
  const RoundTrial trial = impl_->round->Try(StrategyFor(strategy, unknowns(), solver), solver,
                                             impl_->mesh.vertices, {});
  Solution solution;
  solution.x.resize(unknowns());
  const bool free = impl_->context.motion == Motion::kFree;
  for (int k = 0; k < unknowns(); ++k) {
    const int v = impl_->vertex_of_unknown[k];
    const Eigen::Vector3d move = trial.vertices[v] - impl_->mesh.vertices[v];
    solution.x[k] = free ? move[k % 3] : move.dot(impl_->context.normals[v]);
  }
  solution.energy = trial.energy_final["total"];
  solution.iterations = trial.solve.iterations;
  solution.evaluations = trial.evaluations;
  solution.termination = trial.solve.termination;
  return solution;
}

cv::Mat1i LevelEnergy::KeptTaps(int view) {
  const InUse in_use(impl_.get());
  if (view < 0 || view >= static_cast<int>(impl_->views.size())) {
    throw InputError("there is no view " + std::to_string(view));
  }
  const ViewDomain& domain = impl_->domains[view];
  const WindowMasks& masks = impl_->photometric.RoundOf(*impl_->terms).masks(view);
  const int side = impl_->options.photo.window;
  cv::Mat1i taps(domain.height, domain.width, 0);
  for (size_t k = 0; k < domain.facet.size(); ++k) {
    for (const ImagePixel pixel : domain.PixelsOf(k)) taps(pixel.row, pixel.column) = side * side;
  }
  for (int y = 0; y + 1 < static_cast<int>(masks.row_start.size()); ++y) {
    for (uint32_t entry = masks.row_start[y]; entry < masks.row_start[y + 1]; ++entry) {
      int kept = 0;
      for (int word = 0; word < masks.words; ++word) {
        kept += __builtin_popcountll(masks.bits[static_cast<size_t>(entry) * masks.words + word]);
      }
      taps(y, masks.column[entry]) = kept;
    }
  }
  return taps;
}

}  // namespace burin
