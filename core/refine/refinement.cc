#include "core/refine/refinement.h"

#include <glog/logging.h>
#include <malloc.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/mesh/mesh_order.h"
#include "core/mesh/subdivide.h"
#include "core/refine/hidden_folds.h"
#include "core/refine/round.h"
#include "core/refine/unseen_extension.h"
#include "core/scene/pyramid.h"
#include "core/support/error.h"
#include "core/support/stopwatch.h"

namespace burin {
namespace {

// Enough for folds of some tens of vertices across; each round adds its own.
constexpr int kRelaxSweeps = 100;

// The coarsest of the levels asked for whose images all have min_side_px, or else the finest.
int CoarsestLevel(const Scene& scene, const LevelOptions& options) {
  int smallest = scene.views[0].camera.width;
  for (const View& view : scene.views) {
    smallest = std::min({smallest, view.camera.width, view.camera.height});
  }
  int level = options.finest + options.count - 1;
  while (level > options.finest && std::ldexp(smallest, -level) < options.min_side_px) --level;
  return level;
}

// A round frees millions of small blocks (residuals, Jacobian cells) that the next level's large arrays
// cannot use; give their pages back instead of carrying them through the run.
void ReturnFreeMemory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace

double MedianFootprint(const Scene& scene, const TriangleMesh& mesh) {
  std::vector<double> footprints;
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    double smallest = 0;
    for (const View& view : scene.views) {
      if (view.camera.Depth(vertex) <= 0 || !view.camera.Contains(view.camera.Project(vertex))) {
        continue;
      }
      const double footprint = view.camera.Footprint(vertex);
      if (smallest == 0 || footprint < smallest) smallest = footprint;
    }
    if (smallest > 0) footprints.push_back(smallest);
  }
  if (footprints.empty()) return 0;
  std::nth_element(footprints.begin(),
                   footprints.begin() + static_cast<long>(footprints.size() / 2), footprints.end());
  return footprints[footprints.size() / 2];
}

void LevelOptions::Describe(OptionSet* set) {
  set->Add("level.count", &count, "Levels of the image pyramid, each half the size of the next", 1,
           12);
  set->Add("level.min_side_px", &min_side_px,
           "Coarser levels whose images have a smaller side than this are left out", 1, 1000000);
  set->Add("level.finest", &finest, "Finest level used: 0 = full resolution, 1 = half, ...", 0, 11);
  set->Add("level.rounds", &rounds,
           "Rounds of freezing visibility and solving, on the finest level", 1, 1000);
  set->Add("level.extra_rounds", &extra_rounds,
           "Rounds more on every level than on the next finer one", 0, 1000);
  set->Add("level.coarse_tolerance", &coarse_tolerance,
           "solver.function_tolerance on every coarser level", 0, 1);
  set->Add("level.max_facet_px", &max_facet_px,
           "Facets are split to this area in their sharpest view, square pixels of the level", 0.5,
           1e9);
  set->Add("level.max_edge_px", &max_edge_px,
           "Facets with a longer edge are split too, pixel footprints of the level: those seen "
           "obliquely, as on depth steps; 0 = any length",
           0, 1e9);
  set->Add("level.border_px", &border_px,
           "Surface points projecting nearer to the second image's border are left out, pixels", 0,
           1000);
}

void RefinementOptions::Describe(OptionSet* set) {
  level.Describe(set);
  solver.Describe(set);
  guard.Describe(set);
  set->Add("motion.type", &motion, "How vertices move: along their normal of the round, or freely");
  set->Add("motion.hidden", &hidden,
           "Vertices that a pair saw in an earlier round and none sees now: drawn together after "
           "each round, or keep their shape as those never seen do");
}

namespace {

class CoarseToFine {
 public:
  CoarseToFine(const Scene& scene, const std::vector<CameraPair>& pairs,
               const RefinementOptions& options, const std::vector<EnergyTerm*>& terms,
               const RefinementHooks& hooks)
      : scene_(scene), pairs_(pairs), options_(options), terms_(terms), hooks_(hooks) {}
  TriangleMesh Run(const TriangleMesh& input, const RefinementState* start);
  RefinementSummary TakeSummary() { return std::move(state_.summary); }

 private:
  int RoundsOf(int level) const {
    return options_.level.rounds + (level - options_.level.finest) * options_.level.extra_rounds;
  }
  void SetWork();
  void MakeViews(int level);
  // Cuts the mesh to the level's pixels.
  void BeginLevel();
  // Makes context_ of mesh_ as it is now.
  void Freeze(bool hold_back);
  void BeginTerms();
  void RunRound();
  // Lets the judge look at the level, and undoes it when it says so.
  void JudgeLevel();
  // For a run that goes on within a level.
  void ShowJudgeTheStart();
  void End();
  // Minimises the terms on the frozen round from `mesh_` on; the new positions.
  std::vector<Eigen::Vector3d> Solve(RoundSummary* summary);
  bool Report(const IterationRecord& record);
  RoundTrial SolveByHook(RoundProblem* round);
  TriangleMesh InWorld(TriangleMesh mesh) const;

  const Scene& scene_;
  const std::vector<CameraPair>& pairs_;
  const RefinementOptions& options_;
  const std::vector<EnergyTerm*>& terms_;
  const RefinementHooks& hooks_;

  const Stopwatch watch_;
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  double footprint_ = 1;
  int first_level_ = 0;
  RefinementState state_;
  // Of the level in work.
  std::vector<LevelView> views_;
  TriangleMesh mesh_;  // state_.mesh in the order of state_.order
  SolverOptions solver_;
  // Of the round in work; what the context refers to.
  RoundContext context_;
  std::vector<ViewDomain> domains_;
  std::vector<ViewPartners> held_back_;
  bool context_is_of_mesh_ = false;  // a round was solved in it and mesh_ is what it ended with
  // Work is proportional to pixels: level l has 4^-l of them.
  double work_total_ = 0;
  double work_done_ = 0;
  bool stopped_ = false;
};

TriangleMesh CoarseToFine::InWorld(TriangleMesh mesh) const {
  for (Eigen::Vector3d& vertex : mesh.vertices) vertex = vertex * footprint_ + origin_;
  return mesh;
}

void CoarseToFine::SetWork() {
  for (int level = first_level_; level >= options_.level.finest; --level) {
    const double work = std::ldexp(1.0, -2 * level);
    work_total_ += RoundsOf(level) * work;
    if (level > state_.level) work_done_ += RoundsOf(level) * work;
    if (level == state_.level) work_done_ += state_.round * work;
  }
}

void CoarseToFine::MakeViews(int level) {
  context_ = RoundContext();
  domains_.clear();
  held_back_.clear();
  context_is_of_mesh_ = false;
  ReturnFreeMemory();
  const Stopwatch watch;
  views_ = MakeLevelViews(scene_, level, origin_, 1 / footprint_);
  for (EnergyTerm* term : terms_) term->BeginLevel(views_);
  state_.summary.levels.back().image_seconds += watch.Seconds();
}

void CoarseToFine::BeginLevel() {
  const Stopwatch watch;
  std::vector<Camera> cameras;
  cameras.reserve(views_.size());
  for (const LevelView& view : views_) cameras.push_back(view.camera);
  SubdivisionOptions subdivision;
  subdivision.max_facet_px = options_.level.max_facet_px;
  subdivision.max_edge_px = options_.level.max_edge_px;
  const SubdivisionReport split = SplitLargeFaces(&state_.mesh, cameras, subdivision);
  std::vector<char>& was_supported = state_.was_supported;
  for (const std::array<int, 2>& parents : split.new_vertex_parents) {
    was_supported.push_back(
        static_cast<char>(was_supported[parents[0]] & was_supported[parents[1]]));
    state_.input_position.push_back(
        0.5 * (state_.input_position[parents[0]] + state_.input_position[parents[1]]));
  }
  state_.level_start = state_.mesh.vertices;
  state_.order = OrderAlongCurve(state_.mesh);
  LevelSummary& level = state_.summary.levels.back();
  level.subdivide_seconds = watch.Seconds();
  level.level = state_.level;
  level.width = views_[0].camera.width;
  level.height = views_[0].camera.height;
  level.vertices = static_cast<int>(state_.mesh.vertices.size());
  level.faces = static_cast<int>(state_.mesh.faces.size());
}

bool CoarseToFine::Report(const IterationRecord& record) {
  if (!hooks_.on_iteration) return true;
  RefinementEvent event;
  event.level = state_.level;
  event.round = state_.round;
  const double share =
      solver_.max_iterations > 0
          ? std::min(1.0, static_cast<double>(record.iteration) / solver_.max_iterations)
          : 1.0;
  event.done = (work_done_ + share * std::ldexp(1.0, -2 * state_.level)) / work_total_;
  event.iteration = record;
  if (!hooks_.on_iteration(event)) stopped_ = true;
  return !stopped_;
}

RoundTrial CoarseToFine::SolveByHook(RoundProblem* round) {
  const int unknowns = round->Unknowns();
  FrozenRound frozen;
  frozen.level = state_.level;
  frozen.round = state_.round;
  frozen.unknowns = unknowns;
  frozen.context = &context_;
  frozen.world_mesh = [&](const std::vector<Eigen::Vector3d>& now) {
    TriangleMesh moved = state_.mesh;
    RestoreVertices({now, {}}, state_.order, &moved);
    return InWorld(std::move(moved));
  };
  frozen.solve = [&](const std::string& name, const auto& on_iteration) {
    return round->Try(StrategyFor(name, unknowns, solver_), solver_, mesh_.vertices, on_iteration);
  };
  return hooks_.solve_round(frozen);
}

std::vector<Eigen::Vector3d> CoarseToFine::Solve(RoundSummary* summary) {
  const Stopwatch build_watch;
  BeginTerms();
  std::vector<Eigen::Vector3d> positions = mesh_.vertices;
  RoundProblem round(terms_, context_, &positions);
  summary->build_seconds = build_watch.Seconds();
  if (hooks_.judge != nullptr && state_.round == 0) hooks_.judge->BeginLevel(context_);
  round.task.pixel = std::ldexp(1.0, state_.level);
  round.task.on_iteration = [&](const IterationRecord& record) { return Report(record); };
  if (hooks_.solve_round) {
    RoundTrial trial = SolveByHook(&round);
    summary->energy_initial = std::move(trial.energy_initial);
    summary->solve = std::move(trial.solve);
    summary->energy_final = std::move(trial.energy_final);
    summary->solve_seconds = trial.seconds;
    return std::move(trial.vertices);
  }
  const Stopwatch solve_watch;
  const Strategy& strategy = StrategyFor(solver_.type, round.Unknowns(), solver_);
  summary->energy_initial = round.EnergyByTerm();
  summary->solve = strategy.solve(round.task, solver_);
  summary->solve.strategy = strategy.name;
  summary->energy_final = round.EnergyByTerm();
  summary->solve_seconds = solve_watch.Seconds();
  return positions;
}

void CoarseToFine::Freeze(bool hold_back) {
  hold_back &= hooks_.judge != nullptr;
  context_ =
      FreezeRound(views_, pairs_, mesh_, options_.motion, options_.level.border_px, &domains_,
                  hold_back ? hooks_.judge->HeldBackPairs() : std::vector<CameraPair>(),
                  hold_back ? &held_back_ : nullptr);
  context_.first_level = state_.level == first_level_;
}

void CoarseToFine::BeginTerms() {
  for (EnergyTerm* term : terms_) term->BeginRound(context_);
}

void CoarseToFine::RunRound() {
  RoundSummary summary;
  summary.round = state_.round;
  const bool last = state_.round + 1 == RoundsOf(state_.level);
  const Stopwatch visibility_watch;
  Freeze(/*hold_back=*/last || state_.round == 0);
  const bool relax_hidden = options_.hidden == HiddenVertices::kRelax;
  if (relax_hidden) {
    for (size_t v = 0; v < state_.order.vertex.size(); ++v) {
      char& was = state_.was_supported[state_.order.vertex[v]];
      was = static_cast<char>(was | context_.supported[v]);
      context_.was_supported[v] = was;
    }
  }
  summary.visibility_seconds = visibility_watch.Seconds();
  for (const ViewDomain& domain : domains_) {
    for (const int64_t pixels : domain.pair_pixels) summary.pair_pixels += pixels;
  }
  summary.supported_vertices =
      static_cast<int>(std::count(context_.supported.begin(), context_.supported.end(), 1));
  if (summary.pair_pixels == 0) {
    throw InputError("no camera pair sees a common part of the mesh at level " +
                     std::to_string(state_.level) +
                     ": every facet is out of view, hidden, masked or seen from behind");
  }
  const std::vector<Eigen::Vector3d> before = mesh_.vertices;
  std::vector<Eigen::Vector3d> positions = Solve(&summary);
  if (summary.solve.usable) mesh_.vertices = std::move(positions);
  GuardOptions guard = options_.guard;
  // On the way facets of bridges over depth steps turn over and go into folds that vanish.
  guard.inverted &= state_.level == options_.level.finest && last;
  summary.guard = RevertFaults(before, context_.faces, context_.neighbors,
                               std::ldexp(1.0, state_.level), guard, &mesh_);
  summary.carried_vertices = ExtendToUnseen(context_, before, &mesh_);
  if (relax_hidden) {
    summary.relaxed_vertices = RelaxHiddenFolds(context_, kRelaxSweeps, &mesh_);
  }
  RestoreVertices(mesh_, state_.order, &state_.mesh);
  for (EnergyTerm* term : terms_) summary.terms[term->Name()] = term->RoundReport();
  if (hooks_.on_round) hooks_.on_round(context_, mesh_, summary);
  state_.summary.levels.back().rounds.push_back(std::move(summary));
  work_done_ += std::ldexp(1.0, -2 * state_.level);
  context_is_of_mesh_ = true;
}

void CoarseToFine::ShowJudgeTheStart() {
  if (hooks_.judge == nullptr) return;
  const TriangleMesh now = mesh_;
  TriangleMesh start = state_.mesh;
  start.vertices = state_.level_start;
  mesh_ = Ordered(start, state_.order);
  Freeze(/*hold_back=*/true);
  BeginTerms();
  hooks_.judge->BeginLevel(context_);
  mesh_ = now;
}

void CoarseToFine::JudgeLevel() {
  if (hooks_.judge == nullptr) return;
  const LevelVerdict verdict = hooks_.judge->EndLevel(context_, mesh_);
  LevelSummary& level = state_.summary.levels.back();
  level.held_back = verdict.report;
  level.undone = verdict.worse;
  if (!level.undone) return;
  state_.mesh.vertices = state_.level_start;
  context_is_of_mesh_ = false;
}

void CoarseToFine::End() {
  if (!hooks_.on_end) return;
  RefinementEnd end;
  end.level = std::max(state_.level, options_.level.finest);
  if (!context_is_of_mesh_) {
    if (views_.empty()) MakeViews(end.level);  // began after the last level
    if (state_.order.vertex.empty()) state_.order = OrderAlongCurve(state_.mesh);
    mesh_ = Ordered(state_.mesh, state_.order);
    Freeze(/*hold_back=*/false);
    BeginTerms();
  }
  end.context = &context_;
  end.mesh = &mesh_;
  end.index = state_.order.vertex;
  for (const int v : end.index) end.input_position.push_back(state_.input_position[v]);
  hooks_.on_end(end);
}

TriangleMesh CoarseToFine::Run(const TriangleMesh& input, const RefinementState* start) {
  CHECK(!input.vertices.empty());
  origin_ = BoundingBox(input).center();
  footprint_ = MedianFootprint(scene_, input);
  if (footprint_ <= 0) {
    throw InputError("no vertex of the mesh projects into any of the " +
                     std::to_string(scene_.views.size()) +
                     " views: mesh and cameras are not in the same coordinate frame");
  }
  first_level_ = CoarsestLevel(scene_, options_.level);
  if (start != nullptr) {
    state_ = *start;
  } else {
    state_.level = first_level_;
    state_.mesh = input;
    for (Eigen::Vector3d& vertex : state_.mesh.vertices) vertex = (vertex - origin_) / footprint_;
    state_.input_position = state_.mesh.vertices;
    state_.was_supported.assign(input.vertices.size(), 0);
    state_.summary.footprint = footprint_;
  }
  SetWork();
  const double seconds_before = state_.summary.seconds;
  while (state_.level >= options_.level.finest && !stopped_) {
    if (state_.round == 0) state_.summary.levels.emplace_back();
    MakeViews(state_.level);
    if (state_.round == 0) BeginLevel();
    solver_ = options_.solver;
    if (state_.level > options_.level.finest) {
      solver_.function_tolerance = options_.level.coarse_tolerance;
    }
    mesh_ = Ordered(state_.mesh, state_.order);
    if (state_.round > 0) ShowJudgeTheStart();
    const int level = state_.level;
    while (state_.level == level && !stopped_) {
      RunRound();
      state_.summary.seconds = seconds_before + watch_.Seconds();
      if (stopped_) break;
      if (++state_.round == RoundsOf(level)) {
        JudgeLevel();
        if (hooks_.on_level) hooks_.on_level(state_.summary.levels.back(), InWorld(state_.mesh));
        if (--state_.level < options_.level.finest) break;
        state_.round = 0;
        state_.order = MeshOrder();
      }
      if (hooks_.on_state) hooks_.on_state(state_);
    }
  }
  End();
  return InWorld(std::move(state_.mesh));
}

}  // namespace

TriangleMesh Refine(const Scene& scene, const TriangleMesh& input,
                    const std::vector<CameraPair>& pairs, const RefinementOptions& options,
                    const std::vector<EnergyTerm*>& terms, const RefinementHooks& hooks,
                    RefinementSummary* summary, const RefinementState* start) {
  CoarseToFine loop(scene, pairs, options, terms, hooks);
  TriangleMesh refined = loop.Run(input, start);
  *summary = loop.TakeSummary();
  return refined;
}

}  // namespace burin
