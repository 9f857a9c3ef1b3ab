#include "core/refine/level.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "core/mesh/mesh_order.h"
#include "core/mesh/subdivide.h"
#include "core/refine/hidden_folds.h"
#include "core/refine/local_guard.h"
#include "core/refine/round.h"
#include "core/refine/unseen_extension.h"
#include "core/support/error.h"
#include "core/support/stopwatch.h"

namespace burin {
namespace {

// Enough for folds of some tens of vertices across; each round adds its own.
constexpr int kRelaxSweeps = 100;

// Adds what this round sees to what earlier ones saw, in the state and in the context.
void AddToSupport(const MeshOrder& order, std::vector<char>* was_supported, RoundContext* context) {
  for (size_t v = 0; v < order.vertex.size(); ++v) {
    char& was = (*was_supported)[order.vertex[v]];
    was = static_cast<char>(was | context->supported[v]);
    context->was_supported[v] = was;
  }
}

}  // namespace

Level::Level(const RefinementTask& task, int level)
    : task_(task), level_(level), solver_(task.options.solver) {
  if (level > task.options.level.finest) {
    solver_.function_tolerance = task.options.level.coarse_tolerance;
  }
  const Stopwatch watch;
  views_ = MakeLevelViews(task.scene, task.view_levels.At(level), task.world.origin,
                          1 / task.world.footprint);
  for (EnergyTerm* term : task.parts.terms) term->BeginLevel(views_);
  image_seconds_ = watch.Seconds();
}

void Level::Run(RefinementState* state, RefinementProgress* progress) {
  if (state->round == 0) {
    state->summary.levels.emplace_back();
    CutMesh(state);
  }
  state->summary.levels.back().image_seconds += image_seconds_;
  mesh_ = Ordered(state->mesh, state->order);
  if (state->round > 0) ShowJudgeTheStart(*state);
  const int rounds = task_.options.level.RoundsAt(level_);
  while (state->round < rounds) {
    RunRound(state, progress);
    state->summary.seconds = progress->Seconds();
    if (progress->stopped()) break;
    ++state->round;
    if (state->round < rounds && task_.observers.on_state) task_.observers.on_state(*state);
  }
  state->summary.levels.back().interrupted = progress->stopped();
  Judge(state);
  if (task_.observers.on_level) {
    task_.observers.on_level(state->summary.levels.back(), task_.world.ToWorld(state->mesh));
  }
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
  const SubdivisionReport split = SplitLargeFaces(&state->mesh, cameras, subdivision);
  std::vector<char>& was_supported = state->was_supported;
  for (const std::array<int, 2>& parents : split.new_vertex_parents) {
    was_supported.push_back(
        static_cast<char>(was_supported[parents[0]] & was_supported[parents[1]]));
    state->input_position.push_back(
        0.5 * (state->input_position[parents[0]] + state->input_position[parents[1]]));
  }
  state->level_start = {state->mesh.vertices, state->was_supported};
  state->order = OrderAlongCurve(state->mesh);
  LevelSummary& level = state->summary.levels.back();
  level.subdivide_seconds = watch.Seconds();
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
  level.reached_bound = split.reached_bound;
}

std::unique_ptr<Level::Frozen> Level::Freeze(bool hold_back) const {
  hold_back &= task_.parts.judge != nullptr;
  auto frozen = std::make_unique<Frozen>();
  frozen->context = FreezeRound(
      views_, task_.pairs, mesh_, task_.options.motion, task_.options.level.border_px,
      &frozen->domains, hold_back ? task_.parts.judge->HeldBackPairs() : std::vector<CameraPair>(),
      hold_back ? &frozen->held_back : nullptr);
  frozen->context.level = level_;
  frozen->context.first_level = level_ == task_.first_level;
  return frozen;
}

void Level::ShowJudgeTheStart(const RefinementState& state) {
  if (task_.parts.judge == nullptr) return;
  TriangleMesh start = state.mesh;
  start.vertices = state.level_start.vertices;
  const TriangleMesh now = std::exchange(mesh_, Ordered(start, state.order));
  const std::unique_ptr<Frozen> first = Freeze(/*hold_back=*/true);
  FreezeTerms(first.get());
  task_.parts.judge->BeginLevel(first->context, *first->terms);
  mesh_ = now;
}

void Level::RunRound(RefinementState* state, RefinementProgress* progress) {
  RoundSummary summary;
  summary.round = state->round;
  const bool last = state->round + 1 == task_.options.level.RoundsAt(level_);
  const Stopwatch visibility_watch;
  frozen_.reset();
  frozen_ = Freeze(/*hold_back=*/last || state->round == 0);
  RoundContext& context = frozen_->context;
  const bool relax_hidden = task_.options.hidden == HiddenVertices::kRelax;
  if (relax_hidden) AddToSupport(state->order, &state->was_supported, &context);
  summary.visibility_seconds = visibility_watch.Seconds();
  for (const ViewDomain& domain : frozen_->domains) {
    for (const int64_t pixels : domain.pair_pixels) summary.pair_pixels += pixels;
  }
  summary.supported_vertices =
      static_cast<int>(std::count(context.supported.begin(), context.supported.end(), 1));
  if (summary.pair_pixels == 0) {
    throw InputError("no camera pair sees a common part of the mesh at level " +
                     std::to_string(level_) +
                     ": every facet is out of view, hidden, masked or seen from behind");
  }
  const std::vector<Eigen::Vector3d> before = mesh_.vertices;
  std::vector<Eigen::Vector3d> positions = Solve(*state, progress, &summary);
  if (summary.solve.usable) mesh_.vertices = std::move(positions);
  GuardOptions guard = task_.options.guard;
  // On the way facets of bridges over depth steps turn over and go into folds that vanish.
  guard.inverted &= progress->stopped() || (level_ == task_.options.level.finest && last);
  summary.guard = RevertFaults(before, context.faces, context.neighbors, std::ldexp(1.0, level_),
                               guard, &mesh_);
  summary.carried_vertices = ExtendToUnseen(context, before, &mesh_);
  if (relax_hidden) summary.relaxed_vertices = RelaxHiddenFolds(context, kRelaxSweeps, &mesh_);
  RestoreVertices(mesh_, state->order, &state->mesh);
  for (const auto& [term, round] : *frozen_->terms) summary.terms[term->Name()] = round->Report();
  if (task_.observers.on_round) task_.observers.on_round(context, mesh_, summary);
  state->summary.levels.back().rounds.push_back(std::move(summary));
  progress->RoundDone(level_);
}

std::vector<Eigen::Vector3d> Level::Solve(const RefinementState& state,
                                          RefinementProgress* progress, RoundSummary* summary) {
  const Stopwatch build_watch;
  FreezeTerms(frozen_.get());
  RoundParameters parameters{mesh_.vertices};
  RoundProblem problem(*frozen_->terms, frozen_->context, &parameters);
  summary->build_seconds = build_watch.Seconds();
  if (task_.parts.judge != nullptr && state.round == 0) {
    task_.parts.judge->BeginLevel(frozen_->context, *frozen_->terms);
  }
  problem.task.pixel = std::ldexp(1.0, level_);
  problem.task.on_iteration = [&](const IterationRecord& record) {
    return Report(record, state.round, progress);
  };
  if (task_.parts.solve_round) {
    RoundTrial trial = SolveByPart(state, progress, &problem);
    summary->energy_initial = std::move(trial.energy_initial);
    summary->solve = std::move(trial.solve);
    summary->energy_final = std::move(trial.energy_final);
    summary->solve_seconds = trial.seconds;
    return std::move(trial.vertices);
  }
  const Stopwatch solve_watch;
  const Strategy& strategy = StrategyFor(solver_.type, problem.Unknowns(), solver_);
  summary->energy_initial = problem.EnergyByTerm();
  summary->solve = strategy.solve(problem.task, solver_);
  summary->solve.strategy = strategy.name;
  summary->energy_final = problem.EnergyByTerm();
  summary->solve_seconds = solve_watch.Seconds();
  return std::move(parameters.vertices);
}

RoundTrial Level::SolveByPart(const RefinementState& state, RefinementProgress* progress,
                              RoundProblem* problem) {
  const int unknowns = problem->Unknowns();
  FrozenRound round;
  round.level = level_;
  round.round = state.round;
  round.unknowns = unknowns;
  round.context = &frozen_->context;
  round.world_mesh = [&](const std::vector<Eigen::Vector3d>& now) {
    TriangleMesh moved = state.mesh;
    RestoreVertices({now, {}}, state.order, &moved);
    return task_.world.ToWorld(std::move(moved));
  };
  round.solve = [&](const std::string& name, const FrozenRound::OnProgress& on_progress) {
    FrozenRound::OnProgress both = on_progress;
    if (task_.observers.on_iteration) {
      both = [&](const FrozenRound::Progress& trial) {
        const bool goes_on = !on_progress || on_progress(trial);
        return Report(trial.record, state.round, progress) && goes_on;
      };
    }
    return problem->Try(StrategyFor(name, unknowns, solver_), solver_, mesh_.vertices, both);
  };
  return task_.parts.solve_round(round);
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
  if (!task_.observers.on_iteration(event)) progress->Stop();
  return !progress->stopped();
}

void Level::Judge(RefinementState* state) {
  if (task_.parts.judge == nullptr) return;
  if (frozen_->context.held_back == nullptr) {
    // The run was stopped in a round that was not to be the level's last.
    frozen_.reset();
    frozen_ = Freeze(/*hold_back=*/true);
    FreezeTerms(frozen_.get());
  }
  const LevelVerdict verdict =
      task_.parts.judge->EndLevel(frozen_->context, *frozen_->terms, mesh_);
  LevelSummary& level = state->summary.levels.back();
  level.held_back = verdict.report;
  level.undone = verdict.worse;
  if (!level.undone) return;
  state->mesh.vertices = state->level_start.vertices;
  state->was_supported = state->level_start.was_supported;
  frozen_.reset();
}

void Level::ShowEnd(RefinementState* state) {
  if (!task_.observers.on_end) return;
  if (frozen_ == nullptr) {
    if (state->order.vertex.empty()) state->order = OrderAlongCurve(state->mesh);
    mesh_ = Ordered(state->mesh, state->order);
    frozen_ = Freeze(/*hold_back=*/false);
    FreezeTerms(frozen_.get());
  }
  RefinementEnd end;
  end.level = level_;
  end.context = &frozen_->context;
  end.terms = &*frozen_->terms;
  end.mesh = &mesh_;
  end.index = state->order.vertex;
  for (const int v : end.index) end.input_position.push_back(state->input_position[v]);
  task_.observers.on_end(end);
}

}  // namespace burin
