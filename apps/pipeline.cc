#include "apps/pipeline.h"

#include "core/error.h"
#include "core/parallel.h"
#include "core/stopwatch.h"

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
  result.mesh = Refine(scene, mesh, result.selection.pairs, checked.refinement,
                       {&photometric, &smoothness}, hooks, &result.refinement, start);
  return result;
}

}  // namespace burin
