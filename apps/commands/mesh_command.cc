#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/commands/command.h"
#include "apps/commands/commands.h"
#include "apps/commands/mesh_options.h"
#include "apps/run/output_folder.h"
#include "apps/run/progress.h"
#include "apps/run/run_output.h"
#include "apps/run/scene_arguments.h"
#include "apps/run/stop_signals.h"
#include "core/mesh/mesh_check.h"
#include "core/mesh/mesh_io.h"
#include "core/scene/doubts.h"
#include "core/support/atomic_file.h"
#include "core/support/error.h"
#include "core/support/json_file.h"
#include "core/support/parallel.h"
#include "core/support/stopwatch.h"
#include "reconstruct/start_mesh.h"

namespace burin {
namespace {

namespace fs = std::filesystem;

struct MeshCommand {
  MeshCommandOptions options;
  OptionSet set;
  SceneArguments source;
  std::string output;
  std::string depths;
  void Run() const;
};

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

void MeshCommand::Run() const {
  const Stopwatch watch;
  const StopSignals signals;
  const fs::path target = output;
  if (target.extension() != ".ply") throw InputError(target, "is not NAME.ply");
  const ThreadScope threads(options.threads);
  const fs::path parent = target.parent_path();
  const OutputFolder folder(parent.empty() ? fs::path(".") : parent);
  Progress progress;
  progress.Begin(1);
  const bool dense = options.start.points == StartPoints::kDense;
  const Scene scene = LoadScene(source.Source(), /*with_images=*/dense);
  for (const std::string& doubt : DoubtsAbout(scene)) progress.Line(doubt);
  StartObservers observers;
  observers.on_progress = [&](double share, const std::string& doing) {
    progress.Update(share, doing);
  };
  observers.on_line = [&](const std::string& line) { progress.Line(line); };
  if (!depths.empty()) {
    MakeFolder(depths);
    observers.depth_folder = depths;
  }
  observers.check_stop = [&] { signals.ThrowIfCaught(); };
  const StartMesh start = MakeStartMesh(scene, options.start, observers);
  const MeshReport report = CheckMesh(start.mesh);
  progress.Line("mesh: " + report.Brief() + "; " + std::to_string(start.long_facets) +
                " facets with long edges and " + std::to_string(start.small_parts) +
                " small parts were dropped");
  progress.End();
  WriteMesh(target, start.mesh, nullptr, {{"sights", start.sights}});
  nlohmann::ordered_json summary;
  summary["command_line"] = "burin mesh " + source.Text() + " --output " + output;
  summary["versions"] = VersionsJson();
  summary["options"] = OptionsJson(set);
  summary["start"] = StartJson(start, report);
  summary["total_seconds"] = RoundedOrNull(watch.Seconds());
  summary["peak_memory_mib"] = RoundedOrNull(PeakMemoryMib());
  WriteTextAtomically(fs::path(target).replace_extension(".json"), JsonText(summary));
  std::cout << "wrote " << target.string() << ": " << report.vertex_count << " vertices, "
            << report.face_count << " faces; " << std::lround(watch.Seconds()) << " s, "
            << std::lround(PeakMemoryMib()) << " MiB\n";
}

}  // namespace

void AddMeshCommand(Program* program) {
  Command command = program->Add("mesh", "make a mesh to start from, of the scene itself");
  const auto state = std::make_shared<MeshCommand>();
  state->options.Describe(&state->set);
  command.Scene(&state->source, /*photographs=*/true)[0].Required();
  command
      .Text("--output", "FILE (required)", &state->output,
            "mesh to write, NAME.ply; NAME.json beside it says how it was made")
      .Required();
  command.Text(
      "--depths", "DIR", &state->depths,
      "folder to keep depth maps in; a later run with the same photographs goes on from them");
  command.Options(&state->set, {{"start.points", "--points"}});
  command.OnRun([state] { state->Run(); });
}

}  // namespace burin
