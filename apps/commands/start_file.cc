#include "apps/commands/start_file.h"

#include <nlohmann/json.hpp>
#include <vector>

#include "apps/run/progress.h"
#include "apps/run/run_output.h"
#include "core/mesh/mesh_io.h"
#include "core/scene/doubts.h"
#include "core/support/atomic_file.h"
#include "core/support/json_file.h"
#include "core/support/options.h"
#include "core/support/stopwatch.h"
#include "reconstruct/start_mesh.h"

namespace burin {
namespace {

namespace fs = std::filesystem;

nlohmann::ordered_json StartJson(const StartMesh& start, const MeshReport& report) {
  nlohmann::ordered_json json;
  json["sparse_points"] = start.sparse_points;
  json["dense_points"] = start.dense_points;
  json["points"] = start.points;
  json["tetrahedra"] = start.cells;
  json["lines_of_sight"] = start.lines;
  json["lines_lost"] = start.lost_lines;
  json["spacing"] = start.spacing;
  json["vertices"] = report.vertex_count;
  json["faces"] = report.face_count;
  json["parts"] = report.component_count;
  json["boundary_edges"] = report.boundary_edge_count;
  json["long_facets_dropped"] = start.long_facets;
  json["small_parts_dropped"] = start.small_parts;
  for (const StartStage& stage : start.stages) {
    json["stages"].push_back({{"name", stage.name},
                              {"seconds", RoundedOrNull(stage.seconds)},
                              {"processor_seconds", RoundedOrNull(stage.processor_seconds)}});
  }
  return json;
}

}  // namespace

MeshReport WriteStartMesh(const StartFileRequest& request, const StopSignals& signals) {
  const Stopwatch watch;
  Progress progress;
  progress.Begin(1);
  const bool dense = request.options.points == StartPoints::kDense;
  const Scene scene = LoadScene(request.source, /*with_images=*/dense);
  for (const std::string& doubt : DoubtsAbout(scene)) progress.Line(doubt);
  StartObservers observers;
  observers.on_progress = [&](double share, const std::string& doing) {
    progress.Update(share, doing);
  };
  observers.on_line = [&](const std::string& line) { progress.Line(line); };
  observers.check_stop = [&] { signals.ThrowIfCaught(); };
  observers.depth_folder = request.depths;
  if (!request.depths.empty()) MakeFolder(request.depths);
  const StartMesh start = MakeStartMesh(scene, request.options, observers);
  const MeshReport report = CheckMesh(start.mesh);
  progress.Line("mesh: " + report.Brief() + "; " + std::to_string(start.long_facets) +
                " facets with long edges and " + std::to_string(start.small_parts) +
                " small parts were dropped");
  progress.End();
  WriteMesh(request.target, start.mesh, nullptr, {{"sights", start.sights}});
  StartOptions options = request.options;
  OptionSet set;
  options.Describe(&set);
  nlohmann::ordered_json summary;
  summary["command_line"] = request.command_line;
  summary["versions"] = VersionsJson();
  summary["options"] = OptionsJson(set);
  summary["start"] = StartJson(start, report);
  summary["total_seconds"] = RoundedOrNull(watch.Seconds());
  summary["peak_memory_mib"] = RoundedOrNull(PeakMemoryMib());
  WriteTextAtomically(fs::path(request.target).replace_extension(".json"), JsonText(summary));
  return report;
}

std::string MakeInitMesh(const SceneArguments& source, MaskMeaning masks_mean,
                         const fs::path& folder, const StopSignals& signals) {
  StartFileRequest request;
  request.source = source.Source(masks_mean);
  request.target = folder / "init.ply";
  request.depths = folder / "depths";
  request.command_line = "burin mesh " + source.Text() + " --output " + request.target.string();
  Progress().Line("no --mesh: making one of the scene itself, " + request.target.string());
  WriteStartMesh(request, signals);
  fs::remove_all(request.depths);
  return request.target.string();
}

}  // namespace burin
