// What a level shows to its judge, what it takes back, and the level on a surface that is cut anew.
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/mesh/mesh_order.h"
#include "core/refine/level.h"
#include "core/refine/remeshing.h"
#include "core/refine/support.h"
#include "core/support/stopwatch.h"

namespace burin {
namespace {

// What the judge said of the finest level before its surface was cut anew; null where the last level is another.
nlohmann::json ReportBefore(const RefinementState& state) {
  const std::vector<LevelSummary>& levels = state.summary.levels;
  const auto cut_anew = [](const LevelSummary& level) { return level.remeshed_faces > 0; };
  const auto before = std::find_if_not(levels.rbegin() + 1, levels.rend(), cut_anew);
  return before == levels.rend() ? nlohmann::json() : before->held_back;
}

bool HaveOutlines(const std::vector<LevelView>& views) {
  return std::any_of(views.begin(), views.end(),
                     [](const LevelView& view) { return !view.object.empty(); });
}

}  // namespace

void Level::FreezeToShow(bool hold_back, RefinementState* state) {
  frozen_.reset();
  frozen_ = Freeze(*state, hold_back);
  FreezeTerms(frozen_.get());
  if (!HaveOutlines(views_)) return;
  // Which vertices outlines support the terms know of a problem only.
  frozen_->parameters.vertices = mesh_.vertices;
  frozen_->problem =
      std::make_unique<RoundProblem>(*frozen_->terms, frozen_->context, &frozen_->parameters);
  FindSupport(*frozen_->terms, state->order, task_.options.hidden, /*cameras_move=*/false,
              &state->was_supported, &frozen_->context);
}

void Level::Remesh(RefinementState* state) {
  const MeshOrder order = OrderAlongCurve(state->mesh);
  mesh_ = Ordered(state->mesh, order);
  frozen_ = Freeze(*state, /*hold_back=*/true);
  if (task_.parts.judge != nullptr) {
    FreezeTerms(frozen_.get());
    task_.parts.judge->BeginLevel(frozen_->context, *frozen_->terms, LevelFacets::kOther,
                                  ReportBefore(*state));
    frozen_->terms.reset();
  }
  CutAnew(order, RemeshOptions(), state);
  LevelSummary& level = state->summary.levels.back();
  level.remeshed_faces = static_cast<int>(state->remesh_start.mesh.faces.size());
}

// Its rounds make slivers at folds and depth steps.
void Level::MendFacets(RefinementState* state) {
  RemeshOptions options;
  options.iterations = 0;
  CutAnew(state->order, options, state);
  mesh_ = Ordered(state->mesh, state->order);
  if (crossings_.has_value()) crossings_.emplace(mesh_);
  LevelSummary& level = state->summary.levels.back();
  level.vertices = static_cast<int>(state->mesh.vertices.size());
  level.faces = static_cast<int>(state->mesh.faces.size());
}

void Level::CutAnew(const MeshOrder& order, const RemeshOptions& remesh, RefinementState* state) {
  const Stopwatch watch;
  std::vector<Camera> cameras;
  for (const LevelView& view : views_) cameras.push_back(view.camera);
  RemeshingOptions options = task_.options.surface;
  const double finer = state->stage == LevelStage::kCutFiner ? 0.5 : 1;
  options.chord_px *= finer;
  options.min_edge_px *= std::sqrt(finer);
  options.max_edge_px *= std::sqrt(finer);
  std::vector<double> lengths = WantedEdges(mesh_, cameras, frozen_->domains, options);
  frozen_.reset();
  LevelSummary& level = state->summary.levels.back();
  level.reached_bound = !StretchToFit(mesh_, task_.options.level.max_faces, &lengths);
  RemeshState(mesh_, order, lengths, remesh, state);
  level.remesh_seconds += watch.Seconds();
}

void Level::ShowJudge(const RefinementState& state, const TriangleMesh& start,
                      const std::vector<Camera>& cameras, LevelFacets facets) {
  const std::vector<LevelView> views_now = views_;
  SeeThrough(cameras);
  const TriangleMesh now = std::exchange(mesh_, start);
  const std::unique_ptr<Frozen> first = Freeze(state, /*hold_back=*/true);
  FreezeTerms(first.get());
  task_.parts.judge->BeginLevel(first->context, *first->terms, facets, ReportBefore(state));
  mesh_ = now;
  views_ = views_now;
}

void Level::ShowJudgeTheStart(const RefinementState& state) {
  if (task_.parts.judge == nullptr) return;
  if (state.CutsAnew()) {
    const TriangleMesh& start = state.remesh_start.mesh;
    ShowJudge(state, Ordered(start, OrderAlongCurve(start)), state.level_start.cameras,
              LevelFacets::kOther);
    return;
  }
  TriangleMesh start = state.mesh;
  start.vertices = state.level_start.vertices;
  ShowJudge(state, Ordered(start, state.order), state.level_start.cameras, LevelFacets::kSame);
}

void Level::Judge(RefinementState* state) {
  if (task_.parts.judge == nullptr) return;
  if (frozen_ == nullptr || frozen_->context.held_back == nullptr) {
    // The run was stopped in a round that was not to be the level's last.
    FreezeToShow(/*hold_back=*/true, state);
  }
  const LevelVerdict verdict =
      task_.parts.judge->EndLevel(frozen_->context, *frozen_->terms, mesh_);
  LevelSummary& level = state->summary.levels.back();
  level.held_back = verdict.report;
  bool all = true;
  if (state->CutsAnew()) {
    level.undone = std::find(verdict.undo.begin(), verdict.undo.end(), 1) != verdict.undo.end();
    if (!level.undone) return;
    level.undone_vertices = level.vertices;
    UndoRemeshing(state);
    level.vertices = static_cast<int>(state->mesh.vertices.size());
    level.faces = static_cast<int>(state->mesh.faces.size());
    frozen_.reset();
    return;
  }
  for (size_t k = 0; k < verdict.undo.size(); ++k) {
    all &= verdict.undo[k] != 0;
    if (verdict.undo[k] == 0) continue;
    const int v = state->order.vertex[k];
    if (state->mesh.vertices[v] != state->level_start.vertices[v]) ++level.undone_vertices;
    state->mesh.vertices[v] = state->level_start.vertices[v];
    state->was_supported[v] = state->level_start.was_supported[v];
  }
  level.undone = all;
  if (all) {
    state->summary.cameras = state->level_start.cameras;
    SeeThrough(state->summary.cameras);
  }
  if (level.undone_vertices > 0) frozen_.reset();
}

}  // namespace burin
