// One level of a refinement. A state goes in: the level makes its views, cuts the mesh to their pixels,
// runs its rounds and asks the judge; the state that comes out holds the mesh it ended with, or that it
// began with where the judge found it worse.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/mesh/remesh.h"
#include "core/refine/crossing_guard.h"
#include "core/refine/frozen_round.h"
#include "core/refine/normalized_world.h"
#include "core/refine/refinement_options.h"
#include "core/refine/refinement_parts.h"
#include "core/refine/refinement_progress.h"
#include "core/refine/refinement_state.h"
#include "core/refine/view_levels.h"
#include "core/scene/pairs.h"
#include "core/scene/pyramid.h"
#include "core/scene/scene.h"
#include "core/solve/energy_term.h"

namespace burin {

// What is the same on all levels. All of it outlives them.
struct RefinementTask {
  const Scene& scene;
  const std::vector<CameraPair>& pairs;
  const RefinementOptions& options;
  const RefinementParts& parts;
  const RefinementObservers& observers;
  NormalizedWorld world;
  ViewLevels view_levels;
  int first_level = 0;  // the coarsest
};

class Level {
 public:
  // Makes the views of level `level` with these cameras and tells the terms.
  Level(const RefinementTask& task, int level, const std::vector<Camera>& cameras);

  // Runs the rounds that `state`, which is on this level, has before it and judges the level. Ends early
  // when an observer stops the run (progress->stopped()); what was done of the level is judged then. Ends
  // too where no vertex is supported: a level whose first round has none is left out.
  void Run(RefinementState* state, RefinementProgress* progress);

  // The mesh of `state` with a frozen round, to the observer; `state` is what Run() left, or one that
  // ended on this level.
  void ShowEnd(RefinementState* state);

 private:
  // A round's context with what it refers to; the terms in it where they have been frozen.
  struct Frozen {
    RoundContext context;
    std::vector<ViewDomain> domains;
    std::vector<ViewPartners> held_back;
    std::vector<Eigen::Vector3d> level_start;
    std::optional<TermRounds> terms;
    // Of FreezeToShow, where outlines support vertices.
    RoundParameters parameters;
    std::unique_ptr<RoundProblem> problem;
  };

  // A level that takes the place of the coarsest, because all before it were left out or undone, has the
  // rounds of the level before it: it too begins with a mesh that nothing has moved.
  int Rounds(const RefinementState& state) const;
  // Of the state's round among all of the level, those before the surface was cut anew included.
  int RoundNumber(const RefinementState& state) const;
  void CutMesh(RefinementState* state);
  // Cuts the surface of the finest level anew and shows the judge what it was.
  void Remesh(RefinementState* state);
  // After its rounds.
  void MendFacets(RefinementState* state);
  // Of mesh_, which is the state's in the order `order` and seen as frozen_ has it; frozen_ is null then.
  void CutAnew(const MeshOrder& order, const RemeshOptions& remesh, RefinementState* state);
  // What round 0 of a level begins with, into the state and its summary.
  void BeginRounds(RefinementState* state);
  // Figures of a level as it begins and as it ends.
  void CountAtStart(RefinementState* state);
  void CountAtEnd(RefinementState* state);
  // Of the mesh of `state`, in every second pixel of every second row of the views that take part.
  double BackFaceShare(const RefinementState& state) const;
  // Of mesh_ as it is now; the terms are still to be frozen.
  std::unique_ptr<Frozen> Freeze(const RefinementState& state, bool hold_back) const;
  // Into frozen_, for the judge or the end of the run: nothing is solved on it. What outlines support is known.
  void FreezeToShow(bool hold_back, RefinementState* state);
  void FreezeTerms(Frozen* frozen) const {
    frozen->terms.emplace(task_.parts.terms, frozen->context);
  }
  // For a run that goes on within a level.
  void ShowJudgeTheStart(const RefinementState& state);
  // False when no vertex is supported: nothing was done.
  bool RunRound(RefinementState* state, RefinementProgress* progress);
  // Minimises the terms on the frozen round from mesh_ on; the new positions, or nothing when no vertex
  // is supported.
  std::optional<std::vector<Eigen::Vector3d>> Solve(RefinementState* state,
                                                    RefinementProgress* progress,
                                                    RoundSummary* summary);
  RoundTrial SolveByPart(const RefinementState& state, RefinementProgress* progress,
                         RoundProblem* problem);
  // Tells the observer; false when the run is to stop.
  bool Report(const IterationRecord& record, int round, RefinementProgress* progress) const;
  // Takes the world's motion from solved poses and vertices, and returns by how many pixels the cameras moved
  // (core/refine/camera_rounds.h).
  double TakeWorld(const RefinementState& state, const std::vector<CameraPose>& poses,
                   std::vector<Eigen::Vector3d>* vertices, std::vector<Camera>* cameras) const;
  // The views with these cameras of the caller's world.
  void SeeThrough(const std::vector<Camera>& cameras);
  void ShowJudge(const RefinementState& state, const TriangleMesh& start,
                 const std::vector<Camera>& cameras, LevelFacets facets);
  // Lets the judge look at the level, and undoes it when it says so.
  void Judge(RefinementState* state);

  const RefinementTask& task_;
  const int level_;
  SolverOptions solver_;
  double image_seconds_ = 0;
  int64_t windows_ = 0;  // that count at the start of the round in work
  std::vector<LevelView> views_;
  std::vector<Camera> moved_cameras_;       // by the round in work, caller's world; else empty
  std::optional<CrossingGuard> crossings_;  // of mesh_; none with guard.crossings off
  TriangleMesh mesh_;                       // the state's, in the order of its `order`
  std::unique_ptr<Frozen> frozen_;  // the round that mesh_ came from, or of mesh_; else null
};

}  // namespace burin
