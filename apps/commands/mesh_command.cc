#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>

#include "apps/commands/command.h"
#include "apps/commands/commands.h"
#include "apps/commands/mesh_options.h"
#include "apps/commands/start_file.h"
#include "apps/run/run_output.h"
#include "apps/run/scene_arguments.h"
#include "apps/run/stop_signals.h"
#include "core/support/atomic_file.h"
#include "core/support/error.h"
#include "core/support/parallel.h"
#include "core/support/stopwatch.h"

namespace burin {
namespace {

struct MeshCommand {
  MeshCommandOptions options;
  OptionSet set;
  SceneArguments source;
  std::string output;
  std::string depths;
  void Run() const;
};

void MeshCommand::Run() const {
  const Stopwatch watch;
  const StopSignals signals;
  StartFileRequest request;
  request.target = output;
  if (request.target.extension() != ".ply") throw InputError(request.target, "is not NAME.ply");
  const ThreadScope threads(options.threads);
  const std::filesystem::path parent = request.target.parent_path();
  if (!parent.empty()) MakeFolder(parent);
  if (access(parent.empty() ? "." : parent.c_str(), W_OK) != 0) {
    throw InputError(request.target, "its folder cannot be written to");
  }
  request.source = source.Source();
  request.options = options.start;
  request.depths = depths;
  request.command_line = "burin mesh " + source.Text() + " --output " + output;
  const MeshReport report = WriteStartMesh(request, signals);
  std::cout << "wrote " << output << ": " << report.vertex_count << " vertices, "
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
  command.Text("--depths", "DIR", &state->depths,
               "folder to keep depth maps in; a later run with the same photographs uses them");
  command.Options(&state->set, {{"start.points", "--points"}});
  command.OnRun([state] { state->Run(); });
}

}  // namespace burin
