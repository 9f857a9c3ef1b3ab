#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <vector>

#include "apps/commands/command.h"
#include "apps/commands/commands.h"
#include "apps/run/pipeline.h"
#include "apps/run/progress.h"
#include "apps/run/run_output.h"
#include "core/evaluate/evaluation.h"
#include "core/image/picture.h"
#include "core/mesh/mesh_io.h"
#include "core/refine/round.h"
#include "core/scene/formats/colmap.h"
#include "core/scene/pyramid.h"
#include "core/support/atomic_file.h"
#include "core/support/error.h"
#include "core/support/json_file.h"
#include "core/support/parallel.h"
#include "core/synthetic/synthetic.h"
#include "core/visibility/render.h"
#include "costs/warp_picture.h"

namespace burin {
namespace {

struct DemoCommand {
  SyntheticOptions scene_options;
  PipelineOptions options;
  OptionSet set;
  std::string output = "demo";
  void Run();
};

std::string Format(const char* format, double a, double b = 0) {
  char buffer[160];
  std::snprintf(buffer, sizeof(buffer), format, a, b);
  return buffer;
}

// The residual of the first selected pair, dark = none, white = 40 grey levels and more.
WarpPicture FirstPairResidual(const Scene& scene, const TriangleMesh& mesh,
                              const CameraPair& pair) {
  const std::vector<LevelView> views = MakeLevelViews(scene, 0, Eigen::Vector3d::Zero(), 1);
  std::vector<ViewDomain> domains;
  FreezeRound(views, {pair}, mesh, Motion::kNormal, 3, &domains);
  return MakeWarpPicture(views, pair.reference, domains[pair.reference], 0, mesh);
}

cv::Mat Stretched(const cv::Mat1f& residual) {
  cv::Mat picture;
  residual.convertTo(picture, CV_8U, 255.0 / 40);
  return picture;
}

// Of the scene's truth, which stays in memory while the mesh is refined.
double HeldBytes(const SyntheticScene& synthetic) {
  double bytes = static_cast<double>(
      synthetic.truth.vertices.size() * sizeof(Eigen::Vector3d) +
      synthetic.truth.faces.size() * sizeof(Eigen::Vector3i) +
      (synthetic.truth_points.size() + synthetic.truth_normals.size()) * sizeof(Eigen::Vector3d));
  for (const cv::Mat1f& depth : synthetic.depth) {
    bytes += static_cast<double>(depth.total() * depth.elemSize());
  }
  return bytes;
}

void DemoCommand::Run() {
  const std::filesystem::path folder(output);
  std::error_code error;
  std::filesystem::create_directories(folder / "scene", error);
  if (error) throw InputError(folder, "cannot be made: " + error.message());
  const ThreadScope threads(options.threads);

  Progress progress;
  progress.Begin(1);
  progress.Line("making the scene " + NameOf(scene_options.scene));
  const SyntheticScene synthetic = MakeSyntheticScene(scene_options);
  WriteColmapScene(synthetic.scene, folder / "scene", true);
  WriteSyntheticTruth(synthetic, folder / "scene");
  WriteMesh(folder / "scene" / "init.ply", synthetic.init);
  WriteMesh(folder / "scene" / "truth.ply", synthetic.truth);
  RunInputs inputs;
  inputs.memory = CheckMemory(synthetic.scene, synthetic.init, options, HeldBytes(synthetic));
  progress.Line("refining");
  std::vector<RefinementEvent> events;
  PipelineParts parts;
  parts.observers.on_iteration = [&](const RefinementEvent& event) {
    events.push_back(event);
    progress.Update(event.done, "energy " + Format("%.6g", event.iteration.energy));
    return true;
  };
  const PipelineResult result = RunPipeline(synthetic.scene, synthetic.init, options, parts);
  progress.End();

  WriteSurface(folder, result);
  WriteTextAtomically(folder / "trace.csv", TraceCsv(events));
  inputs.command_line = "burin demo --output " + output;
  inputs.scene_path = (folder / "scene").string();
  inputs.mesh_path = (folder / "scene" / "init.ply").string();
  inputs.scene = &synthetic.scene;
  inputs.mesh = &synthetic.init;
  nlohmann::ordered_json summary = SummaryJson(inputs, options, result, progress.ElapsedSeconds());
  const double before = RmseToTruthMesh(synthetic.init, synthetic.truth);
  const double after = RmseToTruthMesh(result.mesh, synthetic.truth);
  summary["rmse_to_truth"] = {{"before", before}, {"after", after}};
  WriteTextAtomically(folder / "summary.json", JsonText(summary));

  const Camera& camera = synthetic.scene.views[synthetic.scene.views.size() / 2].camera;
  WritePicture(folder / "shaded.png",
               SideBySide({RenderShaded(synthetic.init, camera), RenderShaded(result.mesh, camera),
                           RenderShaded(synthetic.truth, camera)},
                          {"initial mesh", "refined", "truth"}));
  ColorScale scale;
  scale.min = -5 * synthetic.footprint;
  scale.max = 5 * synthetic.footprint;
  scale.unit = synthetic.footprint;
  scale.label = "error [px]";
  Truth truth;
  truth.mesh = synthetic.truth;
  WritePicture(
      folder / "error.png",
      SideBySide(
          {RenderVertexScalar(synthetic.init, camera, VertexErrors(synthetic.init, truth), scale),
           RenderVertexScalar(result.mesh, camera, VertexErrors(result.mesh, truth), scale)},
          {"error before, " + Format("RMSE %.2f px", before / synthetic.footprint),
           "error after, " + Format("RMSE %.2f px", after / synthetic.footprint)}));
  const CameraPair& pair = result.selection.pairs.front();
  const WarpPicture residual_before = FirstPairResidual(synthetic.scene, synthetic.init, pair);
  const WarpPicture residual_after = FirstPairResidual(synthetic.scene, result.mesh, pair);
  WritePicture(folder / "residual.png",
               SideBySide({synthetic.scene.views[pair.reference].gray,
                           Stretched(residual_before.residual), Stretched(residual_after.residual)},
                          {"view " + synthetic.scene.views[pair.reference].name,
                           Format("warp residual before, mean %.1f grey levels",
                                  residual_before.mean_residual),
                           Format("after, mean %.1f grey levels", residual_after.mean_residual)}));

  std::cout << Format("RMSE to truth: before %.5f, after %.5f", before, after)
            << Format(" (%.1f times smaller; %.2f px)\n", before / after,
                      after / synthetic.footprint)
            << result.mesh.faces.size() << " faces, " << result.selection.pairs.size() << " pairs, "
            << summary["iterations"] << " iterations, " << summary["evaluations"]
            << " evaluations, "
            << Format("%.1f s refining, %.0f MiB\n", result.refinement.seconds, PeakMemoryMib())
            << "look at " << (folder / "shaded.png").string() << ", "
            << (folder / "error.png").string() << ", " << (folder / "residual.png").string()
            << "\nmeshes: " << (folder / "scene" / "init.ply").string() << ", "
            << (folder / "refined.ply").string() << ", "
            << (folder / "scene" / "truth.ply").string() << "\n";
}

}  // namespace

void AddDemoCommand(Program* program) {
  Command command = program->Add("demo", "make the embedded scene, refine it, score it, draw it");
  const auto state = std::make_shared<DemoCommand>();
  state->scene_options.Describe(&state->set);
  state->options.Describe(&state->set);
  command.Text("--output", "DIR [demo]", &state->output, "folder to write");
  command.Options(&state->set);
  command.OnRun([state] { state->Run(); });
}

}  // namespace burin
