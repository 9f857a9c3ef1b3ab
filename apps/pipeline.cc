#include "apps/pipeline.h"

#include <cmath>
#include <limits>
#include <utility>

#include "core/error.h"
#include "core/parallel.h"
#include "core/stopwatch.h"
#include "costs/held_back.h"
#include "costs/vertex_quality.h"

namespace burin {

void MemoryOptions::Describe(OptionSet* set) {
  set->Add(
      "memory.limit_gb", &limit_gb,
      "A run is refused when its estimated peak memory is above this; 0 = what the machine has "
      "available",
      0, 1e6);
}

void PipelineOptions::Describe(OptionSet* set) {
  pairs.Describe(set);
  photo.Describe(set);
  smooth.Describe(set);
  refinement.Describe(set);
  memory.Describe(set);
  set->Add("run.threads", &threads, "Threads; 0 = all cores. Results do not depend on it", 0, 4096);
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
}

namespace {

constexpr int kVertexGrain = 1024;

// pairs, zncc, displacement_px, sd_px; lengths in pixel footprints of the sharpest view (full
// resolution) whose image the vertex projects into, NaN where there is none.
std::vector<VertexScalar> QualityScalars(const std::vector<LevelView>& views,
                                         const TriangleMesh& mesh,
                                         const std::vector<Eigen::Vector3d>& input_position,
                                         VertexQuality quality, int level) {
  const auto count = static_cast<int>(mesh.vertices.size());
  std::vector<float> displacement(count);
  ParallelFor(count, kVertexGrain, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      double footprint = std::numeric_limits<double>::infinity();
      for (const LevelView& view : views) {
        const Eigen::Vector3d& vertex = mesh.vertices[v];
        if (view.camera.Depth(vertex) <= 0 || !view.camera.Contains(view.camera.Project(vertex))) {
          continue;
        }
        footprint = std::min(footprint, view.camera.Footprint(vertex));
      }
      const double pixels =
          std::isfinite(footprint) ? std::ldexp(1 / footprint, level) : std::nan("");
      displacement[v] = static_cast<float>((mesh.vertices[v] - input_position[v]).norm() * pixels);
      quality.sd[v] *= static_cast<float>(pixels);
    }
  });
  return {{"pairs", std::move(quality.pairs)},
          {"zncc", std::move(quality.zncc)},
          {"displacement_px", std::move(displacement)},
          {"sd_px", std::move(quality.sd)}};
}

LevelVerdict JudgeLevel(const HeldBackVerdict& verdict) {
  LevelVerdict level;
  level.improved = verdict.after <= verdict.before;
  level.report = {{"before", verdict.before},
                  {"after", verdict.after},
                  {"standard_error", verdict.standard_error},
                  {"windows", std::round(verdict.windows)}};
  return level;
}

}  // namespace

PipelineResult RunPipeline(const Scene& scene, const TriangleMesh& mesh,
                           const PipelineOptions& options, const RefinementHooks& hooks,
                           const PairSelection* selection, const RefinementState* start) {
  const PipelineOptions checked = options;  // a hook may change the caller's
  checked.Check();
  SetThreadCount(checked.threads);

  PipelineResult result;
  const Stopwatch watch;
  result.selection = selection != nullptr ? *selection : SelectPairs(scene, mesh, checked.pairs);
  result.selection_seconds = watch.Seconds();
  PhotometricEnergy photometric(checked.photo);
  SmoothnessEnergy smoothness(checked.smooth);
  RefinementHooks all_hooks = hooks;
  if (checked.refinement.guard.levels) {
    photometric.HoldBackSquares(result.selection.held_back.empty());
    all_hooks.judge_level = [&](const std::vector<LevelView>& views, const TriangleMesh& before,
                                const TriangleMesh& after) {
      const Stopwatch judge_watch;
      LevelVerdict verdict = JudgeLevel(
          CompareOnHeldBack(views, result.selection.held_back, result.selection.pairs,
                            checked.refinement.level.border_px, before, after, &photometric));
      verdict.report["seconds"] = judge_watch.Seconds();
      return verdict;
    };
  }
  all_hooks.on_end = [&](int level, const std::vector<LevelView>& views,
                         const TriangleMesh& refined,
                         const std::vector<Eigen::Vector3d>& input_position) {
    photometric.HoldBackSquares(false);
    result.quality =
        QualityScalars(views, refined, input_position,
                       MeasureVertexQuality(views, result.selection.pairs, refined,
                                            checked.refinement.level.border_px, &photometric),
                       level);
  };
  result.mesh = Refine(scene, mesh, result.selection.pairs, checked.refinement,
                       {&photometric, &smoothness}, all_hooks, &result.refinement, start);
  return result;
}

}  // namespace burin
