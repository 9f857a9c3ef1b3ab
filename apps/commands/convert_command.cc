// burin convert SCENE OUT: any scene that burin reads as one that other programs read.
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "apps/commands/command.h"
#include "apps/commands/commands.h"
#include "apps/run/scene_arguments.h"
#include "core/image/gray_image.h"
#include "core/mesh/mesh_io.h"
#include "core/scene/doubts.h"
#include "core/scene/formats/colmap.h"
#include "core/scene/formats/openmvs.h"
#include "core/scene/formats/scene_loader.h"
#include "core/support/atomic_file.h"
#include "core/support/error.h"

namespace burin {
namespace {

namespace fs = std::filesystem;

struct ConvertCommand {
  SceneArguments source;
  std::string output;
  std::string mesh;
  bool text_model = false;
  bool overwrite = false;
  void Run() const;
};

void RefuseExisting(const fs::path& file) {
  std::error_code error;
  if (fs::exists(fs::symlink_status(file, error))) ThrowExists(file);
}

// Whether files of scenes and meshes end so: whoever names one wants no folder.
bool IsNameOfAFile(const fs::path& extension) {
  const std::string text = extension.string();
  for (const char* known :
       {".nvm", ".out", ".json", ".ply", ".obj", ".off", ".txt", ".bin", ".xml"}) {
    if (text == known) return true;
  }
  return false;
}

fs::path MaskPath(const fs::path& folder, const View& view) {
  return folder / "masks" / (view.name + ".png");
}

// Whether the view's mask is there already.
bool HasMask(const fs::path& folder, const View& view) {
  std::error_code error;
  if (!fs::exists(MaskPath(folder, view), error)) return false;
  const cv::Mat there = ReadGrayImage(MaskPath(folder, view)) != 0;
  return there.size() == view.mask.size() && cv::norm(there, view.mask != 0, cv::NORM_INF) == 0;
}

void ConvertCommand::Run() const {
  const fs::path target = output;
  if (target.filename().empty() && !target.has_parent_path()) {
    throw InputError("output: is empty");
  }
  if (target.filename() == ".mvs") throw InputError(target, "has no name before .mvs");
  const bool to_openmvs = target.extension() == ".mvs";
  if (!to_openmvs && !fs::is_directory(target) &&
      (fs::exists(target) || IsNameOfAFile(target.extension()))) {
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
  for (const std::string& doubt : DoubtsAbout(scene)) std::cerr << doubt << "\n";
  const fs::path beside =
      to_openmvs ? folder / (target.stem().string() + "_mesh.ply") : folder / "mesh.ply";
  // Whatever can be wrong is found before anything is written.
  CheckPhotographTargets(posed, folder / "images", overwrite);
  std::vector<const View*> masked;  // whose mask is not there yet
  for (const View& view : scene.views) {
    if (!view.mask.empty() && !HasMask(folder, view)) masked.push_back(&view);
  }
  if (!overwrite) {
    if (to_openmvs) RefuseExisting(target);
    if (!to_openmvs) {
      for (const fs::path& file : ColmapModelFiles(target)) RefuseExisting(file);
    }
    if (!mesh.empty()) RefuseExisting(beside);
    for (const View* view : masked) RefuseExisting(MaskPath(folder, *view));
  }
  WritePhotographs(posed, folder / "images");
  for (const View* view : masked) {
    MakeFolder(MaskPath(folder, *view).parent_path());
    WriteGrayImage(view->mask, MaskPath(folder, *view));
  }
  std::string written = target.string();
  if (to_openmvs) {
    WriteOpenMvs(scene, target);
  } else {
    WriteColmapModel(scene, target, !text_model);
  }
  if (!mesh.empty()) {
    WriteMesh(beside, surface);
    written += " and " + beside.string();
  }
  std::cout << "wrote " << written << ": " << FormatOf(source.scene) << ", " << scene.views.size()
            << " views, " << scene.points.size() << " points\n";
}

}  // namespace

void AddConvertCommand(Program* program) {
  Command command = program->Add(
      "convert", "write a scene as a COLMAP workspace or for OpenMVS, photographs undistorted");
  const auto state = std::make_shared<ConvertCommand>();
  command.Scene(&state->source, /*photographs=*/true)[0].Required();
  command
      .Text("output", "OUTPUT (required)", &state->output,
            "folder, for a COLMAP workspace, or NAME.mvs, for OpenMVS; photographs go to images/ "
            "in the folder, masks to masks/")
      .Required();
  command.Text("--mesh", "FILE", &state->mesh,
               "also write this mesh: mesh.ply in the folder, or NAME_mesh.ply");
  command.Flag("--overwrite", &state->overwrite, "replace files that exist");
  command.Flag("--text", &state->text_model, "write the COLMAP model as text, not binary");
  command.OnRun([state] { state->Run(); });
}

}  // namespace burin
