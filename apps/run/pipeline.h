// From a loaded scene and mesh to a refined mesh: pair selection, the energy terms, the
// coarse-to-fine loop. The refine command, the demo and the tests call this one function.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/run/closing.h"
#include "apps/run/mesh_parts.h"
#include "apps/run/trim_surface.h"
#include "core/cameras/track_step.h"
#include "core/evidence/free_space.h"
#include "core/mesh/mesh.h"
#include "core/mesh/mesh_io.h"
#include "core/refine/camera_rounds.h"
#include "core/refine/refinement.h"
#include "core/scene/mask_options.h"
#include "core/scene/scene.h"
#include "core/support/options.h"
#include "costs/photometric_energy.h"
#include "costs/silhouette_options.h"
#include "costs/smoothness_energy.h"
#include "selection/pair_selection.h"

namespace burin {

// What is done about a scene that cannot be right (core/evidence/verdict.h).
enum class VerdictAction { kStop, kWarn, kOff };
inline Choices<VerdictAction> ChoicesOf(VerdictAction) {
  return {
      {VerdictAction::kStop, "stop"}, {VerdictAction::kWarn, "warn"}, {VerdictAction::kOff, "off"}};
}

// What is done about a view that does not fit the others.
enum class ViewMisfit { kLeaveOut, kWarn, kKeep };
inline Choices<ViewMisfit> ChoicesOf(ViewMisfit) {
  return {{ViewMisfit::kLeaveOut, "leave_out"},
          {ViewMisfit::kWarn, "warn"},
          {ViewMisfit::kKeep, "keep"}};
}

// Of commands, which judge before RunPipeline (apps/run/judged_scene.h).
struct VerdictOptions {
  VerdictAction action = VerdictAction::kStop;
  ViewMisfit misfit = ViewMisfit::kLeaveOut;
  void Describe(OptionSet* set);
};

// What is done about facets that photographs see through (core/evidence/free_space.h).
enum class FreeSpaceAction { kKeep, kIgnore, kCut };
inline Choices<FreeSpaceAction> ChoicesOf(FreeSpaceAction) {
  return {{FreeSpaceAction::kKeep, "keep"},
          {FreeSpaceAction::kIgnore, "ignore"},
          {FreeSpaceAction::kCut, "cut"}};
}

struct SurfaceOptions {
  FreeSpaceAction free_space = FreeSpaceAction::kIgnore;
  SurfaceTrim trim = SurfaceTrim::kEvidence;  // needs PipelineParts::measure_quality
  void Describe(OptionSet* set);
};

// run.threads, of every command that has it.
void DescribeThreads(int* threads, OptionSet* set);

// Of commands that choose pairs and refine nothing.
struct SelectOptions {
  MeshOptions mesh;
  PairsOptions pairs;
  int threads = 0;  // 0 = all cores
  void Describe(OptionSet* set);
};

struct MemoryOptions {
  double limit_gb = 0;  // 0 = what the machine has available (apps/run/memory_estimate.h)
  void Describe(OptionSet* set);
};

// Mirrors the stages; every option of a run is in here.
struct PipelineOptions {
  ImageMaskOptions masks;  // of commands, which load scenes
  MeshOptions mesh;  // of commands, which orient it before RunPipeline (apps/run/mesh_parts.h)
  PairsOptions pairs;
  PhotometricOptions photo;
  SmoothnessOptions smooth;
  SilhouetteTermOptions silhouette;
  RefinementOptions refinement;
  VerdictOptions verdict;
  SurfaceOptions surface;
  MemoryOptions memory;
  int threads = 0;  // 0 = all cores
  void Describe(OptionSet* set);
  // Throws InputError for values out of range or that do not fit together.
  void Check() const;
};

struct PipelineResult {
  TriangleMesh mesh;
  PairSelection selection;
  RefinementSummary refinement;
  std::vector<VertexScalar>
      quality;  // of `mesh`, as docs/options.md names them; empty if not asked for
  std::optional<ClosingFigures> closing;  // likewise
  std::optional<Trimming> trimming;    // the mesh before; nothing where surface.trim takes no part
  std::vector<char> seen_with_part;    // likewise, by vertex of the mesh given: see SeenWithPart
  std::optional<TrackStep> by_tracks;  // the one that was made in this run
  std::shared_ptr<const Scene> seen;   // TrackStep::seen of the run; null: as given
  FreeSpace free_space;                // of the mesh given; no patches with surface.free_space keep
  double selection_seconds = 0;
  double free_space_seconds = 0;
  double surface_seconds = 0;  // what is known of the surface, and trimming

  const Scene& SeenOr(const Scene& scene) const { return seen != nullptr ? *seen : scene; }
};

// What a caller may bring to a run. Nothing is owned.
struct PipelineParts {
  RefinementObservers observers;
  const PairSelection* selection = nullptr;  // what SelectPairs made, or pairs chosen otherwise
  const TrackStep* by_tracks = nullptr;      // what RefineByTracks made of the selection
  const RefinementState* start = nullptr;    // to go on from: see Refine()
  bool tracks_hold_all = false;              // with `start`: TrackStep::HoldsAllViews of that run
  std::vector<EnergyTerm*> more_terms;       // added to the energy
  LevelJudge* judge = nullptr;               // in place of the one that guard.levels asks for
  std::function<RoundTrial(const FrozenRound&)> solve_round;  // see RefinementParts
  std::function<void(const TrackStep&)> on_cameras;           // before refining
  // Before refining, where rounds that would move cameras leave them alone (core/refine/camera_rounds.h).
  std::function<void(const SmallLevels&)> on_small_levels;
  std::function<void(const FreeSpace&)> on_free_space;  // before refining, where there is some
  bool measure_quality = true;                          // fill PipelineResult::quality and closing
};

// Throws InputError for anything wrong with scene, mesh or options.
PipelineResult RunPipeline(const Scene& scene, const TriangleMesh& mesh,
                           const PipelineOptions& options, const PipelineParts& parts = {});

}  // namespace burin
