#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "apps/commands/command.h"
#include "apps/commands/commands.h"
#include "apps/run/mesh_parts.h"
#include "apps/run/scene_arguments.h"
#include "core/evaluate/evaluation.h"
#include "core/image/picture.h"
#include "core/mesh/mesh_io.h"
#include "core/support/error.h"
#include "core/support/options.h"
#include "core/visibility/render.h"

namespace burin {
namespace {

struct PictureCommand {
  EvaluationOptions options;
  OptionSet set;
  SceneArguments source;
  std::string mesh;
  std::string truth;
  std::string output;
  std::string view;

  const View& ViewOf(const Scene& views) const;
  void Run() const;
};

const View& PictureCommand::ViewOf(const Scene& views) const {
  if (view.empty()) return views.views[views.views.size() / 2];
  for (const View& one : views.views) {
    if (one.name == view) return one;
  }
  throw InputError("--view " + view + ": the scene has no view of this name");
}

void PictureCommand::Run() const {
  const double largest = options.Thresholds().back();
  const Scene views = LoadScene(source.Source(), /*with_images=*/false);
  const View& from = ViewOf(views);
  const TriangleMesh measured = ReadMesh(mesh);
  CheckMeshIsSeen(views, measured, mesh);
  const Truth loaded = ReadTruth(truth);
  const TriangleMesh placed = Moved(measured, TruthFromMesh(measured, loaded, options));
  ColorScale scale;
  scale.min = -largest;
  scale.max = largest;
  scale.unit = options.unit;
  scale.label = "error";
  WritePicture(
      output,
      SideBySide({RenderShaded(measured, from.camera),
                  RenderVertexScalar(measured, from.camera,
                                     VertexErrors(placed, loaded, options.MatchingDistance(loaded)),
                                     scale)},
                 {"", ""}));
}

}  // namespace

void AddPictureCommand(Program* program) {
  Command command = program->Add(
      "picture", "draw a mesh and its errors, as evaluate measures them, from a view of the scene");
  const auto state = std::make_shared<PictureCommand>();
  state->options.Describe(&state->set);
  command.Scene(&state->source, /*photographs=*/false)[0].Required();
  command.Text("--mesh", "FILE (required)", &state->mesh, "PLY, OBJ, OFF or STL").Required();
  command
      .Text("--truth", "FILE (required)", &state->truth,
            "mesh, or PLY point cloud, best with normals")
      .Required();
  command
      .Text("--output", "FILE (required)", &state->output,
            "picture to write, .png or .jpg: left shaded, right the signed errors of the "
            "vertices in unit, colours up to the largest tau")
      .Required();
  command.Text("--view", "NAME", &state->view, "view to draw from (default: the middle one)");
  command.Options(&state->set, {}, [state] { state->options.Thresholds(); });
  command.OnRun([state] { state->Run(); });
}

}  // namespace burin
