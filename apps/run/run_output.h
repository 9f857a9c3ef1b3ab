// What a refinement writes beside the mesh: summary.json, from which a run can be repeated and judged,
// and trace.csv with one line per iteration.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "apps/run/memory_limit.h"
#include "apps/run/mesh_parts.h"
#include "apps/run/pipeline.h"

namespace burin {

// {"group.name": value, ...} with the JSON type of each option, in the order of the set.
nlohmann::ordered_json OptionsJson(const OptionSet& set);

// Versions of burin and of the libraries it runs with.
nlohmann::ordered_json VersionsJson();

// Peak resident memory of this process, MiB.
double PeakMemoryMib();

struct RunInputs {
  std::string command_line;
  std::string scene_path;
  std::string mesh_path;
  const Scene* scene = nullptr;
  const TriangleMesh* mesh = nullptr;
  std::string mesh_report;  // one line of checks
  MeshParts parts;
  double load_seconds = 0;
  MemoryCheck memory;   // made before the run
  std::string verdict;  // JSON; empty = not judged
  double verdict_seconds = 0;
  std::string cameras;          // TrackStepJson; empty = cameras are not refined
  const Scene* used = nullptr;  // the scene without views that were left out; null = `scene`
};

// Which parts of the mesh took none in the refinement: marks them, and counts them in the closing figures.
void CloseParts(const TriangleMesh& input, PipelineResult* result, MeshParts* parts);

// Everything about a finished run. `total_seconds` includes reading and writing.
nlohmann::ordered_json SummaryJson(const RunInputs& inputs, const PipelineOptions& options,
                                   const PipelineResult& result, double total_seconds);

// refined.ply, and whole.ply where something may be cut away; where not, one of an earlier run is removed.
void WriteSurface(const std::filesystem::path& folder, const PipelineResult& result);

// CSV text: level,round,iteration,energy,gradient_max,step_norm,accepted,linear_iterations,seconds
std::string TraceCsv(const std::vector<RefinementEvent>& events);

}  // namespace burin
