#include "apps/run/pipeline.h"

#include <algorithm>
#include <utility>

#include "apps/run/free_space_output.h"
#include "apps/run/measure_closing.h"
#include "apps/run/surface_quality.h"
#include "core/cameras/lens_change.h"
#include "core/cameras/refined_scene.h"
#include "core/support/error.h"
#include "core/support/parallel.h"
#include "core/support/stopwatch.h"
#include "costs/held_back.h"
#include "costs/silhouette_energy.h"
#include "costs/vertex_quality.h"

namespace burin {

void VerdictOptions::Describe(OptionSet* set) {
  set->Add("verdict.action", &action,
           "Where cameras, photographs and mesh cannot be right together: stop = the input mesh is "
           "the result, exit code 4; warn = say so and go on; off = do not judge");
  set->Add("scene.misfit", &misfit,
           "Views that do not fit the others: leave_out = name them and go on without; warn = name "
           "them; keep = neither; not judged with verdict.action off");
}

void SurfaceOptions::Describe(OptionSet* set) {
  set->Add("surface.free_space", &free_space,
           "Facets of the mesh that photographs see through: ignore = they take no part, are not "
           "split, and "
           "hide nothing; cut = they are not in the result either; keep = they are not looked for");
  set->Add(
      "surface.trim", &trim,
      "What is cut away of the refined mesh; whole.ply keeps it: none = nothing; unseen = what no "
      "camera pair sees; evidence = also what too few pairs see well enough to tell where it is "
      "(docs/surface.md)");
}

void MemoryOptions::Describe(OptionSet* set) {
  set->Add(
      "memory.limit_gb", &limit_gb,
      "A run is refused when its estimated peak memory is above this; 0 = what the machine has "
      "available",
      0, 1e6);
}

void DescribeThreads(int* threads, OptionSet* set) {
  set->Add("run.threads", threads, "Threads; 0 = all cores. Results do not depend on it", 0, 4096);
}

void SelectOptions::Describe(OptionSet* set) {
  mesh.Describe(set);
  pairs.Describe(set);
  DescribeThreads(&threads, set);
}

void PipelineOptions::Describe(OptionSet* set) {
  masks.Describe(set);
  mesh.Describe(set);
  pairs.Describe(set);
  photo.Describe(set);
  smooth.Describe(set);
  silhouette.Describe(set);
  refinement.Describe(set);
  verdict.Describe(set);
  surface.Describe(set);
  memory.Describe(set);
  DescribeThreads(&threads, set);
}

void PipelineOptions::Check() const {
  PipelineOptions described = *this;  // describing needs a place to point to
  OptionSet set;
  described.Describe(&set);
  std::string error;
  if (!set.IsValid(&error)) throw InputError(error);
  if (photo.window % 2 == 0) {
    throw InputError("photo.window = " + std::to_string(photo.window) + ": must be odd");
  }
  pairs.Check();
  if (silhouette.weight > 0 && masks.meaning == MaskMeaning::kIgnore) {
    throw InputError("silhouette.weight: needs masks.meaning = object, and masks of the object");
  }
  const CamerasOptions& cameras = refinement.cameras;
  if (IntrinsicsOf(cameras.refine) != IntrinsicUnknowns::kNone && !cameras.ByTracks()) {
    throw InputError("cameras.steps = joint: moves poses only; cameras.refine = " +
                     std::string(NameOf(cameras.refine)) + " needs tracks or both");
  }
  if (cameras.Jointly() && cameras.coarsest_joint < cameras.finest_joint) {
    throw InputError("cameras.coarsest_joint = " + std::to_string(cameras.coarsest_joint) +
                     ": must be at least cameras.finest_joint, " +
                     std::to_string(cameras.finest_joint) +
                     " (levels count from 0, full resolution; cameras.steps = tracks has no joint "
                     "rounds)");
  }
}

namespace {

// What the levels and the free space say, into the closing figures.
void CloseSurface(const PipelineOptions& options, PipelineResult* result) {
  if (!result->closing.has_value()) return;
  ClosingFigures& closing = *result->closing;
  if (!result->free_space.hidden.empty() && options.surface.free_space != FreeSpaceAction::kCut) {
    closing.hidden_view = result->free_space.hidden[0].view;
    closing.hidden_share = result->free_space.hidden[0].share;
  }
  const std::vector<LevelSummary>& levels = result->refinement.levels;
  if (options.refinement.guard.crossings == Crossings::kOff || levels.empty()) return;
  closing.back_faces_before = levels.front().back_faces.before;
  closing.back_faces_after = levels.back().back_faces.after;
  if (levels.back().faces > 0) {
    closing.crossing_facets = static_cast<double>(levels.back().crossing_facets.after) /
                              static_cast<double>(levels.back().faces);
  }
}

}  // namespace

PipelineResult RunPipeline(const Scene& scene, const TriangleMesh& mesh,
                           const PipelineOptions& options, const PipelineParts& parts) {
  PipelineOptions checked = options;  // an observer may change the caller's
  checked.Check();
  const ThreadScope threads(checked.threads);
  if (checked.silhouette.weight > 0 &&
      std::all_of(scene.views.begin(), scene.views.end(),
                  [](const View& view) { return view.object.empty(); })) {
    throw InputError("silhouette.weight: no view of the scene has a mask of the object");
  }

  PipelineResult result;
  const Stopwatch watch;
  result.selection =
      parts.selection != nullptr ? *parts.selection : SelectPairs(scene, mesh, checked.pairs);
  result.selection_seconds = watch.Seconds();
  RefinementParts refinement;
  const CameraUnknowns unknowns = checked.refinement.cameras.refine;
  if (checked.refinement.cameras.refine != CameraUnknowns::kNone) {
    if (parts.start != nullptr) {
      refinement.cameras = parts.start->summary.first_cameras;
      refinement.lenses = parts.start->summary.lenses;
      if (!refinement.lenses.empty()) {
        result.seen = std::make_shared<const Scene>(
            WithIntrinsics(scene, refinement.cameras, refinement.lenses));
      }
    } else if (checked.refinement.cameras.ByTracks()) {
      result.by_tracks = parts.by_tracks != nullptr
                             ? *parts.by_tracks
                             : RefineByTracks(scene, mesh, result.selection.ForTracks(),
                                              RuleOf(unknowns), IntrinsicsOf(unknowns));
      refinement.cameras = result.by_tracks->cameras;
      result.seen = result.by_tracks->seen;
      if (result.seen != nullptr) refinement.lenses = result.by_tracks->bundle.lenses;
      if (parts.on_cameras) parts.on_cameras(*result.by_tracks);
    }
  }
  const Scene& seen = result.SeenOr(scene);
  // What tracks find nothing wrong with, the joint rounds leave alone.
  CamerasOptions& cameras = checked.refinement.cameras;
  if (cameras.refine == CameraUnknowns::kAuto && cameras.ByTracks() &&
      AreCamerasOf(scene, refinement.cameras)) {
    cameras.refine = CameraUnknowns::kNone;
  }
  if (cameras.ByTracks() && cameras.Jointly() &&
      (result.by_tracks.has_value() ? result.by_tracks->HoldsAllViews() : parts.tracks_hold_all)) {
    const ViewLevels levels(seen, mesh, checked.refinement.level);
    const SmallLevels small = LeaveOutSmallLevels(
        seen, levels, levels.Coarsest(result.selection.pairs, result.selection.held_back),
        &cameras);
    if (small.Any() && parts.on_small_levels) parts.on_small_levels(small);
  }
  TriangleMesh without;  // patches in free space
  const TriangleMesh* refined = &mesh;
  if (checked.surface.free_space != FreeSpaceAction::kKeep) {
    const Stopwatch free_space_watch;
    result.free_space = FindFreeSpace(AreCamerasOf(seen, refinement.cameras)
                                          ? seen
                                          : WithRefinedCameras(seen, refinement.cameras),
                                      mesh, result.selection.pairs);
    result.free_space_seconds = free_space_watch.Seconds();
    if (!result.free_space.patches.empty()) {
      if (parts.on_free_space) parts.on_free_space(result.free_space);
      without = WithoutPatches(mesh, result.free_space);
      refined = &without;
    }
  }
  const std::vector<CameraPair>& held_back = result.selection.held_back;
  const bool judged = checked.refinement.guard.levels && parts.judge == nullptr;
  PhotometricEnergy photometric(checked.photo, /*hold_back_squares=*/judged && held_back.empty());
  SmoothnessEnergy smoothness(checked.smooth);
  SilhouetteEnergy silhouette(checked.silhouette);
  HeldBackJudge judge(held_back, &photometric);
  refinement.terms = {&photometric, &smoothness};
  if (checked.silhouette.weight > 0) {
    refinement.terms.push_back(&silhouette);
    checked.refinement.level.more_on_finest = checked.silhouette.rounds;
  }
  refinement.terms.insert(refinement.terms.end(), parts.more_terms.begin(), parts.more_terms.end());
  refinement.judge = judged ? &judge : parts.judge;
  refinement.solve_round = parts.solve_round;
  std::vector<CutReason> reasons;  // by facet
  RefinementObservers observers = parts.observers;
  if (parts.measure_quality) {
    observers.on_end = [&](const RefinementEnd& end) {
      const VertexQuality quality =
          MeasureVertexQuality(*end.mesh, &photometric.RoundOf(*end.terms));
      const Stopwatch surface_watch;
      SurfaceQuality surface = MeasureSurface(end, quality, checked.surface.trim);
      result.surface_seconds = surface_watch.Seconds();
      result.quality = std::move(surface.scalars);
      result.seen_with_part = SeenWithPart(end, quality.pairs, mesh.vertices.size());
      reasons = std::move(surface.reasons);
      result.closing =
          MeasureClosing(scene, seen, *refined, result.selection, checked.refinement.level,
                         checked.photo, judged && held_back.empty(), end, quality);
      if (parts.observers.on_end) parts.observers.on_end(end);
    };
  }
  result.mesh = Refine(seen, *refined, result.selection.pairs, checked.refinement, refinement,
                       observers, &result.refinement, parts.start);
  CloseSurface(checked, &result);
  const LevelSummary& last = result.refinement.levels.back();
  const bool cut_anew = last.remeshed_faces > 0 && !last.undone;
  if (checked.surface.free_space != FreeSpaceAction::kCut) {
    if (cut_anew) {
      AppendPatches(mesh, result.free_space, &result.mesh, &result.quality);
    } else {
      PutPatchesBack(mesh, result.free_space, &result.mesh);
    }
  } else if (!cut_anew) {
    DropPatchVertices(mesh, result.free_space, &result.mesh, &result.quality);
  }
  // A mesh that is handed back is as it was given.
  if (checked.surface.trim != SurfaceTrim::kNone && result.closing.has_value() &&
      result.closing->moved) {
    const Stopwatch trim_watch;
    result.trimming =
        TrimSurface(checked.surface.trim, std::move(reasons), &result.mesh, &result.quality);
    result.surface_seconds += trim_watch.Seconds();
  }
  return result;
}

}  // namespace burin
