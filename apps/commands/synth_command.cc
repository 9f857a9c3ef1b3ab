#include <filesystem>
#include <iostream>
#include <memory>
#include <string>

#include "apps/commands/command.h"
#include "apps/commands/commands.h"
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
            << "  true_cameras/     the cameras that took the photographs\n"
            << "one pixel covers " << synthetic.footprint << " world units\n";
}

}  // namespace

void AddSynthCommand(Program* program) {
  Command command = program->Add("synth", "make a scene with exact truth");
  const auto state = std::make_shared<SynthCommand>();
  state->options.Describe(&state->set);
  command.Text("--output", "DIR (required)", &state->output, "folder to write, a COLMAP workspace")
      .Required();
  command.Flag("--text", &state->text_model, "write the COLMAP model as text, not binary");
  command.Options(&state->set, {{"synth.scene", "--scene"}, {"synth.mesh_path", "--mesh"}});
  command.OnRun([state, command] {
    state->scene_given = command.Given("--scene");
    state->Run();
  });
}

}  // namespace burin
