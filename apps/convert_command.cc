// burin convert SCENE OUT: any scene that burin reads as one that other programs read.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>

#include "apps/commands.h"
#include "apps/scene_arguments.h"
#include "core/error.h"
#include "core/formats/colmap.h"
#include "core/formats/openmvs.h"
#include "core/formats/scene_loader.h"
#include "core/mesh_io.h"

namespace burin {
namespace {

namespace fs = std::filesystem;

struct ConvertCommand {
  SceneArguments source;
  std::string output;
  std::string mesh;
  bool text_model = false;
  void Run() const;
};

void ConvertCommand::Run() const {
  const fs::path target = output;
  const bool to_openmvs = target.extension() == ".mvs";
  if (!to_openmvs && target.has_extension() && !fs::is_directory(target)) {
    throw InputError(target, "is neither a folder (COLMAP) nor NAME.mvs (OpenMVS)");
  }
  if (to_openmvs && text_model) throw InputError("--text: is for COLMAP models only");
  if (IsSameFile(target, source.scene)) {
    throw InputError(target, "is the scene itself: name another one to write");
  }
  const fs::path folder = to_openmvs ? target.parent_path() : target;
  TriangleMesh surface;
  if (!mesh.empty()) surface = ReadMesh(mesh);
  const PosedScene posed = ReadScene(source.Source());
  // With the photographs: they are looked at before anything is written, and colour the points.
  const Scene scene = MakeScene(posed, /*with_images=*/true, source.masks);
  for (const PosedImage& image : posed.images) {
    const fs::path photograph = folder / "images" / image.name;
    if (!image.lens.IsNone() && IsSameFile(photograph, image.image_path)) {
      throw InputError(photograph,
                       "would be replaced by its undistorted version: name another output");
    }
  }
  WritePhotographs(posed, folder / "images");
  std::string written = target.string();
  if (to_openmvs) {
    WriteOpenMvs(scene, target);
  } else {
    WriteColmapModel(scene, target, !text_model);
  }
  if (!mesh.empty()) {
    const fs::path beside =
        to_openmvs ? folder / (target.stem().string() + "_mesh.ply") : folder / "mesh.ply";
    WriteMesh(beside, surface);
    written += " and " + beside.string();
  }
  std::cout << "wrote " << written << ": " << FormatOf(source.scene) << ", " << scene.views.size()
            << " views, " << scene.points.size() << " points\n";
}

}  // namespace

void AddConvertCommand(CLI::App* program) {
  CLI::App* app = program->add_subcommand(
      "convert", "write a scene as a COLMAP workspace or for OpenMVS, photographs undistorted");
  const auto command = std::make_shared<ConvertCommand>();
  command->source.AddTo(app, /*photographs=*/false)[0]->required();
  app->add_option(
         "output", command->output,
         "folder, for a COLMAP workspace, or NAME.mvs, for OpenMVS; photographs go to images/ "
         "in the folder")
      ->option_text("OUTPUT (required)")
      ->required();
  app->add_option("--mesh", command->mesh,
                  "also write this mesh: mesh.ply in the folder, or NAME_mesh.ply")
      ->option_text("FILE");
  app->add_flag("--text", command->text_model, "write the COLMAP model as text, not binary");
  app->callback([command] { command->Run(); });
}

}  // namespace burin
