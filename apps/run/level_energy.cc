#include "apps/run/level_energy.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "core/refine/camera_rounds.h"
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

constexpr int kMotion = 6;

// d of Exp(w + dw) Exp(w)^-1 = Exp(d), by dw.
Eigen::Matrix3d LeftJacobian(const Eigen::Vector3d& w) {
  Eigen::Matrix3d cross;
  cross << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
  const double angle = w.norm();
  // Of (1 - cos) / angle^2 and (angle - sin) / angle^3.
  const bool is_small = angle < 1e-4;
  const double a = is_small ? 0.5 : (1 - std::cos(angle)) / (angle * angle);
  const double b = is_small ? 1.0 / 6 : (angle - std::sin(angle)) / (angle * angle * angle);
  return Eigen::Matrix3d::Identity() + a * cross + b * cross * cross;
}

// How the unknowns of the equations (core/solve/motion.h: half a rotation vector) change with a camera's at w.
Eigen::MatrixXd ChangeAt(const Eigen::Vector3d& w) {
  Eigen::MatrixXd change = Eigen::MatrixXd::Identity(kMotion, kMotion);
  change.topLeftCorner<3, 3>() = LeftJacobian(w) / 2;
  return change;
}

}  // namespace

struct LevelEnergy::Impl {
  Impl(const Scene& scene, const TriangleMesh& world, const std::vector<CameraPair>& pairs,
       const PipelineOptions& o, int level, bool cameras)
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
    if (cameras) parameters.cameras = PosesOf(views);
    for (const View& view : scene.views) given.push_back(view.camera);
    round = std::make_unique<RoundProblem>(*terms, context, &parameters);
    round->SupportIsKnown();
    round->task.pixel = std::ldexp(1.0, level);
    equations =
        std::make_unique<NormalEquations>(*round->task.energy, round->task.evaluation_callback);
    equations->Save(&start);
    vertex_of_unknown.assign(equations->unknowns(), -1);
    camera_of_unknown.assign(equations->unknowns(), -1);
    const RoundEnergy& energy = *round->task.energy;
    for (const NormalEquations::MovingBlock& block : equations->moving_blocks()) {
      for (int k = 0; k < block.tangent_size; ++k) {
        if (energy.IsCamera(block.parameter)) {
          camera_of_unknown[block.first_unknown + k] = block.parameter - energy.FirstCamera();
        } else {
          vertex_of_unknown[block.first_unknown + k] = block.parameter;
        }
      }
    }
  }

  int FirstCameraUnknown() const { return equations->matrix().size; }
  int MovingCameras() const { return static_cast<int>(equations->border().columns().size()); }
  // Of each camera that moves; see ChangeAt.
  std::vector<Eigen::MatrixXd> ChangesAt(const Eigen::VectorXd& x) const {
    std::vector<Eigen::MatrixXd> changes;
    changes.reserve(MovingCameras());
    for (int k = 0; k < MovingCameras(); ++k) {
      changes.push_back(ChangeAt(x.segment<3>(FirstCameraUnknown() + kMotion * k)));
    }
    return changes;
  }
  // Of the equations' gradient at x that by x.
  void ChangeGradient(const Eigen::VectorXd& x, Eigen::VectorXd* gradient) const {
    const std::vector<Eigen::MatrixXd> changes = ChangesAt(x);
    for (int k = 0; k < MovingCameras(); ++k) {
      auto own = gradient->segment<kMotion>(FirstCameraUnknown() + kMotion * k);
      own = (changes[k].transpose() * own).eval();
    }
  }

  void MoveTo(const Eigen::VectorXd& x) {
    if (x.size() != equations->unknowns()) {
      throw InputError("x: has " + std::to_string(x.size()) + " entries, must have " +
                       std::to_string(equations->unknowns()));
    }
    Eigen::VectorXd delta = x;
    for (int k = 0; k < MovingCameras(); ++k) {
      delta.segment<3>(FirstCameraUnknown() + kMotion * k) /= 2;  // core/solve/motion.h
    }
    equations->SetPlus(start, delta);
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
  std::vector<int> camera_of_unknown;
  std::vector<Camera> given;
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
                         int level, bool cameras)
    : impl_(std::make_unique<Impl>(scene, mesh, pairs, options, level, cameras)) {}

LevelEnergy::~LevelEnergy() = default;

int LevelEnergy::unknowns() const { return impl_->equations->unknowns(); }
double LevelEnergy::footprint() const { return impl_->normalized.footprint; }
const std::vector<int>& LevelEnergy::vertex_of_unknown() const { return impl_->vertex_of_unknown; }
const std::vector<int>& LevelEnergy::camera_of_unknown() const { return impl_->camera_of_unknown; }
const std::vector<Eigen::Vector3d>& LevelEnergy::normals() const { return impl_->context.normals; }

double LevelEnergy::Evaluate(const Eigen::VectorXd& x, Eigen::VectorXd* gradient) {
  const InUse in_use(impl_.get());
  impl_->MoveTo(x);
  double energy = 0;
  gradient->resize(unknowns());
  if (!impl_->equations->EvaluateGradient(&energy, gradient)) return std::nan("");
  impl_->ChangeGradient(x, gradient);
  return energy;
}

SymmetricMatrix LevelEnergy::Linearize(const Eigen::VectorXd& x, double* energy,
                                       Eigen::VectorXd* gradient) {
  const InUse in_use(impl_.get());
  impl_->MoveTo(x);
  gradient->resize(unknowns());
  if (!impl_->equations->Evaluate(energy, gradient)) *energy = std::nan("");
  impl_->ChangeGradient(x, gradient);
  return impl_->equations->WholeMatrix(impl_->ChangesAt(x));
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

std::vector<Camera> LevelEnergy::CamerasAt(const Eigen::VectorXd& x) const {
  const InUse in_use(impl_.get());
  impl_->MoveTo(x);
  std::vector<Camera> cameras = impl_->given;
  for (size_t v = 0; v < impl_->parameters.cameras.size(); ++v) {
    CameraPose pose = impl_->parameters.cameras[v];
    const Eigen::Vector3d center =
        impl_->normalized.origin +
        impl_->normalized.footprint * Eigen::Map<const Eigen::Vector3d>(pose.center);
    Eigen::Map<Eigen::Vector3d>(pose.center) = center;
    SetPose(pose, &cameras[v]);
  }
  return cameras;
}

LevelEnergy::Solution LevelEnergy::Solve(const std::string& strategy) {
  const InUse in_use(impl_.get());
  const SolverOptions& solver = impl_->options.refinement.solver;
  const RoundTrial trial = impl_->round->Try(StrategyFor(strategy, unknowns(), solver), solver,
                                             impl_->mesh.vertices, {});
  Solution solution;
  solution.x.resize(unknowns());
  const bool free = impl_->context.motion == Motion::kFree;
  for (int k = 0; k < impl_->MovingCameras(); ++k) {
    const int first = impl_->FirstCameraUnknown() + kMotion * k;
    const int camera = impl_->camera_of_unknown[first];
    const CameraPose from = PoseOf(impl_->views[camera].camera);
    const CameraPose& to = trial.cameras[camera];
    const Eigen::AngleAxisd turn(Eigen::Map<const Eigen::Quaterniond>(to.rotation) *
                                 Eigen::Map<const Eigen::Quaterniond>(from.rotation).inverse());
    solution.x.segment<3>(first) = turn.angle() * turn.axis();
    solution.x.segment<3>(first + 3) = Eigen::Map<const Eigen::Vector3d>(to.center) -
                                       Eigen::Map<const Eigen::Vector3d>(from.center);
  }
  for (int k = 0; k < impl_->FirstCameraUnknown(); ++k) {
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
