#include "core/refine/level.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "core/mesh/mesh_order.h"
#include "core/mesh/subdivide.h"
#include "core/refine/camera_rounds.h"
#include "core/refine/carry.h"
#include "core/refine/facet_texture.h"
#include "core/refine/hidden_folds.h"
#include "core/refine/local_guard.h"
#include "core/refine/round.h"
#include "core/refine/support.h"
#include "core/support/error.h"
#include "core/support/stopwatch.h"
#include "core/visibility/back_faces.h"

namespace burin {
namespace {

// Enough for folds of some tens of vertices across; each round adds its own.
constexpr int kRelaxSweeps = 100;

// No level before the last one has moved anything.
bool IsFirst(const std::vector<LevelSummary>& levels) {
  return std::all_of(levels.begin(), levels.end() - 1,
                     [&](const LevelSummary& other) { return other.left_out || other.undone; });
}

}  // namespace

Level::Level(const RefinementTask& task, int level, const std::vector<Camera>& cameras)
    : task_(task), level_(level), solver_(task.options.solver) {
  if (level > task.options.level.finest) {
    solver_.function_tolerance = task.options.level.coarse_tolerance;
  }
  const Stopwatch watch;
  views_ = MakeLevelViews(task.scene, cameras, task.view_levels.At(level), task.world.origin,
                          1 / task.world.footprint);
  for (EnergyTerm* term : task.parts.terms) term->BeginLevel(views_);
  image_seconds_ = watch.Seconds();
}

void Level::Run(RefinementState* state, RefinementProgress* progress) {
  if (state->round == 0) {
    state->summary.levels.emplace_back();
    if (state->CutsAnew()) {
      Remesh(state);
    } else {
      CutMesh(state);
    }
    BeginRounds(state);
  }
  state->summary.levels.back().image_seconds += std::exchange(image_seconds_, 0);
  mesh_ = Ordered(state->mesh, state->order);
  if (task_.options.guard.crossings != Crossings::kOff) {
    crossings_.emplace(mesh_);
    if (state->round == 0) CountAtStart(state);
  }
  if (state->round > 0) ShowJudgeTheStart(*state);
  const int rounds = Rounds(*state);
  progress->RoundsSpared(level_, PlannedRounds(task_.options, level_, state->stage) - rounds);
  while (state->round < rounds) {
    if (!RunRound(state, progress)) {
      progress->RoundsSpared(level_, rounds - state->round);
      break;
    }
    state->summary.seconds = progress->Seconds();
    if (progress->stopped()) break;
    ++state->round;
    if (state->round < rounds && task_.observers.on_state) task_.observers.on_state(*state);
  }
  LevelSummary& summary = state->summary.levels.back();
  summary.left_out = summary.rounds.empty();
  summary.interrupted = progress->stopped();
  if (state->CutsAnew() && !summary.interrupted && frozen_ != nullptr) MendFacets(state);
  if (!summary.left_out) Judge(state);
  if (crossings_.has_value()) CountAtEnd(state);
  if (task_.observers.on_level) task_.observers.on_level(summary, task_.world.ToWorld(state->mesh));
}

int Level::Rounds(const RefinementState& state) const {
  const bool late = state.stage == LevelStage::kGiven && level_ != task_.first_level &&
                    IsFirst(state.summary.levels);
  const int more = late ? task_.options.level.extra_rounds : 0;
  return RoundsOf(task_.options, level_, state.stage, more);
}

int Level::RoundNumber(const RefinementState& state) const {
  const std::vector<LevelSummary>& levels = state.summary.levels;
  return std::accumulate(levels.begin(), levels.end() - 1, state.round,
                         [&](int sum, const LevelSummary& other) {
                           const bool same = other.level == level_ && !other.left_out;
                           return sum + (same ? static_cast<int>(other.rounds.size()) : 0);
                         });
}

void Level::CutMesh(RefinementState* state) {
  const Stopwatch watch;
  std::vector<Camera> cameras;
  for (const LevelView& view : views_) {
    if (view.at.takes_part) cameras.push_back(view.camera);
  }
  SubdivisionOptions subdivision;
  subdivision.max_facet_px = task_.options.level.max_facet_px;
  subdivision.max_edge_px = task_.options.level.max_edge_px;
  subdivision.max_face_count = task_.options.level.max_faces;
  const TriangleMesh whole = state->mesh;
  const FacetTexture texture(views_, whole);
  subdivision.is_worth_it = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                const Eigen::Vector3d& c) { return texture.InTwoViews(a, b, c); };
  const SubdivisionReport split = SplitLargeFaces(&state->mesh, cameras, subdivision);
  std::vector<char>& was_supported = state->was_supported;
  for (const std::array<int, 2>& parents : split.new_vertex_parents) {
    was_supported.push_back(
        static_cast<char>(was_supported[parents[0]] & was_supported[parents[1]]));
    state->input_position.push_back(
        0.5 * (state->input_position[parents[0]] + state->input_position[parents[1]]));
  }
  state->order = OrderAlongCurve(state->mesh);
  LevelSummary& level = state->summary.levels.back();
  level.subdivide_seconds = watch.Seconds();
  level.reached_bound = split.reached_bound;
}

void Level::BeginRounds(RefinementState* state) {
  state->level_start = {state->mesh.vertices, state->was_supported, state->summary.cameras};
  LevelSummary& level = state->summary.levels.back();
  level.level = level_;
  const Camera& name = NamesLevel(views_).camera;
  level.width = name.width;
  level.height = name.height;
  for (const LevelView& view : views_) {
    if (!view.at.takes_part) continue;
    ++level.views;
    if (view.at.halvings != level_) ++level.views_halved_less;
  }
  level.vertices = static_cast<int>(state->mesh.vertices.size());
  level.faces = static_cast<int>(state->mesh.faces.size());
}

void Level::CountAtStart(RefinementState* state) {
  std::vector<LevelSummary>& levels = state->summary.levels;
  LevelSummary& level = levels.back();
  // Of a surface that is cut anew: as it was before.
  level.crossing_facets.before = state->stage != LevelStage::kGiven
                                     ? levels[levels.size() - 2].crossing_facets.after
                                     : crossings_->Facets();
  // To split facets changes nothing that a view sees.
  level.back_faces.before =
      levels.size() > 1 ? levels[levels.size() - 2].back_faces.after : BackFaceShare(*state);
}

void Level::CountAtEnd(RefinementState* state) {
  LevelSummary& level = state->summary.levels.back();
  if (level.undone_vertices > 0) crossings_.emplace(Ordered(state->mesh, state->order));
  level.crossing_facets.after = crossings_->Facets();
  level.back_faces.after = level.left_out ? level.back_faces.before : BackFaceShare(*state);
}

double Level::BackFaceShare(const RefinementState& state) const {
  std::vector<Camera> cameras;
  for (const LevelView& view : views_) {
    if (!view.at.takes_part) continue;
    cameras.push_back(
        view.camera.Resized((view.camera.width + 1) / 2, (view.camera.height + 1) / 2));
  }
  return CountBackFaces(state.mesh, cameras).Share();
}

std::unique_ptr<Level::Frozen> Level::Freeze(const RefinementState& state, bool hold_back) const {
  hold_back &= task_.parts.judge != nullptr;
  auto frozen = std::make_unique<Frozen>();
  frozen->context = FreezeRound(
      views_, task_.pairs, mesh_, task_.options.motion, task_.options.level.border_px,
      &frozen->domains, hold_back ? task_.parts.judge->HeldBackPairs() : std::vector<CameraPair>(),
      hold_back ? &frozen->held_back : nullptr);
  frozen->context.level = level_;
  frozen->context.first_level = IsFirst(state.summary.levels);
  frozen->context.finest_level = level_ == task_.options.level.finest;
  const size_t count = mesh_.vertices.size();
  if (state.level_start.vertices.size() == count && state.order.vertex.size() == count) {
    for (const int v : state.order.vertex) {
      frozen->level_start.push_back(state.level_start.vertices[v]);
    }
    frozen->context.level_start = &frozen->level_start;
  }
  return frozen;
}

bool Level::RunRound(RefinementState* state, RefinementProgress* progress) {
  RoundSummary summary;
  summary.round = RoundNumber(*state);
  const bool last = state->round + 1 == Rounds(*state);
  const Stopwatch visibility_watch;
  frozen_.reset();
  frozen_ = Freeze(*state, /*hold_back=*/last || (state->round == 0 && !state->CutsAnew()));
  RoundContext& context = frozen_->context;
  summary.visibility_seconds = visibility_watch.Seconds();
  for (const ViewDomain& domain : frozen_->domains) {
    for (const int64_t pixels : domain.pair_pixels) summary.pair_pixels += pixels;
  }
  const std::vector<Eigen::Vector3d> before = mesh_.vertices;
  std::optional<std::vector<Eigen::Vector3d>> positions = Solve(state, progress, &summary);
  if (!positions.has_value()) return false;
  if (summary.solve.usable) mesh_.vertices = *std::move(positions);
  GuardOptions guard = task_.options.guard;
  // On the way facets of bridges over depth steps turn over and go into folds that vanish.
  guard.inverted &= progress->stopped() || (level_ == task_.options.level.finest && last);
  summary.guard = RevertFaults(before, context.faces, context.neighbors, std::ldexp(1.0, level_),
                               guard, &mesh_);
  summary.carried_vertices = CarryAlong(context.neighbors, context.moves, before, &mesh_);
  if (task_.options.hidden == HiddenVertices::kRelax) {
    summary.relaxed_vertices = RelaxHiddenFolds(context, kRelaxSweeps, &mesh_);
  }
  if (crossings_.has_value()) {
    summary.crossings = crossings_->EndRound(
        before, context, task_.options.guard.crossings == Crossings::kTakeBack, &mesh_);
  }
  RestoreVertices(mesh_, state->order, &state->mesh);
  for (const auto& [term, round] : *frozen_->terms) summary.terms[term->Name()] = round->Report();
  if (task_.observers.on_round) task_.observers.on_round(context, mesh_, summary);
  state->summary.levels.back().rounds.push_back(std::move(summary));
  progress->RoundDone(level_);
  if (!moved_cameras_.empty()) {
    frozen_.reset();  // it was of the views as they were
    state->summary.cameras = std::exchange(moved_cameras_, {});
    SeeThrough(state->summary.cameras);
  }
  return true;
}

std::optional<std::vector<Eigen::Vector3d>> Level::Solve(RefinementState* state,
                                                         RefinementProgress* progress,
                                                         RoundSummary* summary) {
  const Stopwatch build_watch;
  FreezeTerms(frozen_.get());
  RoundParameters parameters{mesh_.vertices};
  const bool goes_on = level_ == task_.options.level.finest;
  const int all =
      Rounds(*state) + (goes_on ? PlannedRounds(task_.options, level_, LevelStage::kCutAnew) : 0);
  const bool joint = state->stage == LevelStage::kGiven &&
                     MovesCameras(task_.options.cameras, level_, state->round, all);
  if (joint) parameters.cameras = PosesOf(views_);
  RoundProblem problem(*frozen_->terms, frozen_->context, &parameters);
  summary->build_seconds = build_watch.Seconds();
  if (task_.parts.judge != nullptr && state->round == 0 && !state->CutsAnew()) {
    task_.parts.judge->BeginLevel(frozen_->context, *frozen_->terms, LevelFacets::kSame, nullptr);
  }
  summary->supported_vertices = FindSupport(*frozen_->terms, state->order, task_.options.hidden,
                                            joint, &state->was_supported, &frozen_->context);
  if (summary->supported_vertices == 0) return std::nullopt;
  problem.SupportIsKnown();
  windows_ = problem.WindowCount();
  problem.task.pixel = std::ldexp(1.0, level_);
  problem.task.on_iteration = [&](const IterationRecord& record) {
    return Report(record, RoundNumber(*state), progress);
  };
  if (task_.parts.solve_round) {
    RoundTrial trial = SolveByPart(*state, progress, &problem);
    summary->energy_initial = std::move(trial.energy_initial);
    summary->solve = std::move(trial.solve);
    summary->energy_final = std::move(trial.energy_final);
    summary->windows_initial = trial.windows_initial;
    summary->windows_final = trial.windows_final;
    summary->solve_seconds = trial.seconds;
    if (trial.cameras.size() == views_.size() && summary->solve.usable) {
      moved_cameras_ = state->summary.cameras;
      std::vector<Eigen::Vector3d> seen = mesh_.vertices;  // those of the trial have it taken out
      summary->camera_px = TakeWorld(*state, trial.cameras, &seen, &moved_cameras_);
    }
    return std::move(trial.vertices);
  }
  const Stopwatch solve_watch;
  const Strategy& strategy = StrategyFor(
      joint ? StrategyForCameras(solver_.type, problem.Unknowns(), solver_) : solver_.type,
      problem.Unknowns(), solver_);
  summary->energy_initial = problem.EnergyByTerm();
  summary->windows_initial = windows_;
  summary->solve = strategy.solve(problem.task, solver_);
  summary->solve.strategy = strategy.name;
  summary->energy_final = problem.EnergyByTerm();
  summary->windows_final = problem.WindowCount();
  summary->solve_seconds = solve_watch.Seconds();
  if (joint && summary->solve.usable) {
    moved_cameras_ = state->summary.cameras;
    summary->camera_px =
        TakeWorld(*state, parameters.cameras, &parameters.vertices, &moved_cameras_);
  }
  return std::move(parameters.vertices);
}

bool Level::Report(const IterationRecord& record, int round, RefinementProgress* progress) const {
  if (!task_.observers.on_iteration) return true;
  RefinementEvent event;
  event.level = level_;
  event.round = round;
  const double share =
      solver_.max_iterations > 0
          ? std::min(1.0, static_cast<double>(record.iteration) / solver_.max_iterations)
          : 1.0;
  event.done = progress->Share(level_, share);
  event.iteration = record;
  event.windows = windows_;
  if (!task_.observers.on_iteration(event)) progress->Stop();
  return !progress->stopped();
}

void Level::SeeThrough(const std::vector<Camera>& cameras) {
  for (size_t v = 0; v < views_.size(); ++v) {
    const Camera& camera = views_[v].camera;
    views_[v].camera = task_.world.FromWorld(cameras[v], camera.width, camera.height);
  }
}

void Level::ShowEnd(RefinementState* state) {
  if (!task_.observers.on_end) return;
  if (frozen_ == nullptr) {
    if (state->order.vertex.empty()) state->order = OrderAlongCurve(state->mesh);
    mesh_ = Ordered(state->mesh, state->order);
    FreezeToShow(/*hold_back=*/false, state);
  }
  RefinementEnd end;
  end.level = level_;
  end.cameras = &state->summary.cameras;
  end.context = &frozen_->context;
  end.terms = &*frozen_->terms;
  end.mesh = &mesh_;
  end.index = state->order.vertex;
  end.face_index = state->order.face;
  for (const int v : end.index) {
    end.input_position.push_back(state->input_position[v]);
    if (!state->part.empty()) end.part.push_back(state->part[v]);
  }
  task_.observers.on_end(end);
}

}  // namespace burin
