#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "apps/commands.h"
#include "apps/debug_images.h"
#include "apps/option_binding.h"
#include "apps/output_folder.h"
#include "apps/pipeline.h"
#include "apps/progress.h"
#include "apps/run_output.h"
#include "core/atomic_file.h"
#include "core/colmap.h"
#include "core/config.h"
#include "core/mesh_io.h"
#include "core/picture.h"
#include "core/render.h"
#include "core/stopwatch.h"

namespace burin {
namespace {

struct RefineCommand {
  PipelineOptions options;
  OptionSet set;
  std::string scene_path;
  std::string mesh_path;
  std::string output_path;
  bool pictures = false;
  bool debug_images = false;
  void Run();
  void WritePictures(const std::filesystem::path& folder, const Scene& scene,
                     const TriangleMesh& before, const TriangleMesh& after) const;
};

std::string EventText(const RefinementEvent& event) {
  std::ostringstream text;
  text << "level " << event.level << " round " << event.round + 1 << " iteration "
       << event.iteration.iteration << " energy " << event.iteration.energy;
  return text.str();
}

std::string RoundText(const RoundContext& context, const TriangleMesh& mesh,
                      const RoundSummary& round) {
  std::ostringstream text;
  text << "level " << (*context.views)[0].camera.width << "x" << (*context.views)[0].camera.height
       << " round " << round.round + 1 << ": " << mesh.faces.size() << " faces, "
       << round.pair_pixels << " pixel pairs, " << round.solve.strategy << " "
       << round.solve.iterations << " iterations, energy "
       << round.energy_initial["total"].get<double>() << " -> "
       << round.energy_final["total"].get<double>();
  return text.str();
}

// The middle view of the scene: its photograph and both meshes, shaded from its camera.
void RefineCommand::WritePictures(const std::filesystem::path& folder, const Scene& scene,
                                  const TriangleMesh& before, const TriangleMesh& after) const {
  const View& view = scene.views[scene.views.size() / 2];
  cv::Mat photograph;
  view.gray.convertTo(photograph, CV_8U);
  WritePicture(
      folder / "before_after.png",
      SideBySide({photograph, RenderShaded(before, view.camera), RenderShaded(after, view.camera)},
                 {view.name, "before", "after"}));
}

void RefineCommand::Run() {
  const Stopwatch watch;
  options.Check();
  const OutputFolder output(output_path);
  const std::filesystem::path& folder = output.path();
  MeshReport report;
  const TriangleMesh mesh = ReadMesh(mesh_path, &report);
  RunInputs inputs;
  inputs.memory = CheckMemory(LoadColmapScene(scene_path, /*with_images=*/false), mesh, options);
  const Scene scene = LoadColmapScene(scene_path);
  CheckMeshIsSeen(scene, mesh, mesh_path);
  inputs.command_line = "burin refine " + scene_path + " --mesh " + mesh_path + " --output " +
                        output_path + " --config " + (folder / "config.toml").string();
  inputs.scene_path = scene_path;
  inputs.mesh_path = mesh_path;
  inputs.scene = &scene;
  inputs.mesh = &mesh;
  inputs.mesh_report = report.Brief();
  inputs.load_seconds = watch.Seconds();

  Progress progress;
  progress.Begin(1);
  progress.Line("read " + std::to_string(scene.views.size()) + " views, " +
                std::to_string(scene.points.size()) + " points; mesh: " + report.Brief());
  std::vector<std::string> names;
  for (const View& view : scene.views) names.push_back(view.name);
  if (debug_images) std::filesystem::create_directories(folder / "debug");
  std::vector<RefinementEvent> events;
  RefinementHooks hooks;
  hooks.on_iteration = [&](const RefinementEvent& event) {
    events.push_back(event);
    progress.Update(event.done, EventText(event));
    return true;
  };
  hooks.on_round = [&](const RoundContext& context, const TriangleMesh& now,
                       const RoundSummary& round) {
    progress.Line(RoundText(context, now, round));
    if (debug_images && round.round == 0) {
      const int level = static_cast<int>(std::lround(std::log2(
          static_cast<double>(scene.views[0].camera.width) / (*context.views)[0].camera.width)));
      WriteDebugImages(folder / "debug", level, context, options.photo, names);
    }
  };
  const PipelineResult result = RunPipeline(scene, mesh, options, hooks);
  for (const std::string& warning : result.selection.warnings) {
    progress.Line("no partner: " + warning);
  }
  progress.End();

  WriteMesh(folder / "refined.ply", result.mesh);
  WriteTextAtomically(folder / "trace.csv", TraceCsv(events));
  WriteTextAtomically(folder / "config.toml", ConfigText(set));
  if (pictures) WritePictures(folder, scene, mesh, result.mesh);
  WriteTextAtomically(folder / "summary.json",
                      SummaryJson(inputs, options, result, watch.Seconds()).dump(2) + "\n");
  std::cout << "wrote " << (folder / "refined.ply").string() << ": " << result.mesh.vertices.size()
            << " vertices, " << result.mesh.faces.size() << " faces; "
            << result.selection.pairs.size() << " pairs, " << std::lround(watch.Seconds()) << " s, "
            << std::lround(PeakMemoryMib()) << " MiB\n";
}

}  // namespace

void AddRefineCommand(CLI::App* program) {
  CLI::App* app = program->add_subcommand("refine", "refine a mesh against its photographs");
  const auto command = std::make_shared<RefineCommand>();
  command->options.Describe(&command->set);
  app->add_option("scene", command->scene_path,
                  "COLMAP workspace: images/ and sparse/ or sparse/0/, text or binary")
      ->option_text("SCENE_DIR (required)")
      ->required();
  app->add_option("--mesh", command->mesh_path, "mesh to start from: PLY, OBJ or OFF")
      ->option_text("FILE (required)")
      ->required();
  app->add_option("--output", command->output_path,
                  "folder for refined.ply, summary.json and trace.csv")
      ->option_text("DIR (required)")
      ->required();
  app->add_flag("--pictures", command->pictures,
                "also write before_after.png: the middle view and both meshes seen from it");
  app->add_flag("--debug.images", command->debug_images,
                "also write debug/: per level and view, the taps its windows keep and its first "
                "pair's errors with and without masks");
  BindOptions(&command->set, app, {}, [command] { command->options.Check(); });
  app->callback([command] { command->Run(); });
}

}  // namespace burin
