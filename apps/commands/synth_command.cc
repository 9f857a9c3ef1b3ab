#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>

#include "apps/commands/commands.h"
#include "apps/commands/option_binding.h"
#include "apps/run/output_folder.h"
#include "core/mesh/mesh_io.h"
#include "core/scene/formats/colmap.h"
#include "core/support/error.h"
#include "core/support/options.h"
#include "core/synthetic/synthetic.h"

namespace burin {
namespace {

struct SynthCommand {
  SyntheticOptions options;
  OptionSet set;
  std::string output;
  bool text_model = false;
  bool scene_given = false;

  void Run();
};

void SynthCommand::Run() {
  if (!options.mesh_path.empty()) {
    if (scene_given && options.scene != SyntheticKind::kScan) {
      throw InputError("--mesh: only the scene scan is made from a mesh, not " +
                       NameOf(options.scene));
    }
    options.scene = SyntheticKind::kScan;
  } else if (options.scene == SyntheticKind::kScan) {
    throw InputError("--mesh: the scene scan needs a mesh file");
  }
  const OutputFolder made(output);
  const std::filesystem::path& folder = made.path();
  TriangleMesh scan;
  if (options.scene == SyntheticKind::kScan) scan = ReadMesh(options.mesh_path);
  const SyntheticScene synthetic = MakeSyntheticScene(options, scan);
  WriteColmapScene(synthetic.scene, folder, !text_model);
  WriteMesh(folder / "init.ply", synthetic.init);
  WriteMesh(folder / "truth.ply", synthetic.truth);
  WriteSyntheticTruth(synthetic, folder);
  std::cout << "wrote " << output << ": scene " << NameOf(options.scene) << ", "
            << synthetic.scene.views.size() << " views of " << options.width << "x"
            << options.height << ", " << synthetic.scene.points.size() << " sparse points\n"
            << "  init.ply          " << synthetic.init.vertices.size() << " vertices, "
            << synthetic.init.faces.size() << " faces\n"
            << "  truth.ply         " << synthetic.truth.vertices.size() << " vertices, "
            << synthetic.truth.faces.size() << " faces\n"
            << "  truth_points.ply  " << synthetic.truth_points.size() << " points with normals\n"
            << "one pixel covers " << synthetic.footprint << " world units\n";
}

}  // namespace

void AddSynthCommand(CLI::App* program) {
  CLI::App* app = program->add_subcommand("synth", "make a scene with exact truth");
  const auto command = std::make_shared<SynthCommand>();
  command->options.Describe(&command->set);
  app->add_option("--output", command->output, "folder to write, a COLMAP workspace")
      ->option_text("DIR (required)")
      ->required();
  app->add_flag("--text", command->text_model, "write the COLMAP model as text, not binary");
  BindOptions(&command->set, app, {{"synth.scene", "--scene"}, {"synth.mesh_path", "--mesh"}});
  app->callback([command, app] {
    command->scene_given = app->count("--scene") > 0;
    command->Run();
  });
}

}  // namespace burin
