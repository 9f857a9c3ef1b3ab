#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "apps/commands.h"
#include "apps/option_binding.h"
#include "core/colmap.h"
#include "core/error.h"
#include "core/evaluation.h"
#include "core/evaluation_report.h"
#include "core/mesh_io.h"
#include "core/options.h"
#include "core/silhouette.h"

namespace burin {
namespace {

struct EvaluateCommand {
  EvaluationOptions options;
  OptionSet set;
  std::string mesh;
  std::string truth;
  std::string scene;
  std::string depth;
  double depth_unit = 1;
  SilhouetteOptions silhouette;
  bool json = false;

  std::vector<char> BoundaryFlags(const Truth& loaded) const {
    if (scene.empty() && depth.empty()) return {};
    if (scene.empty() || depth.empty()) {
      throw InputError("--scene and --depth: both or neither, they belong together");
    }
    if (loaded.IsMesh()) {
      throw InputError(truth, "must be a point cloud to split by --scene and --depth");
    }
    const Scene views = LoadColmapScene(scene, /*with_images=*/false);
    std::vector<Camera> cameras;
    for (const View& view : views.views) cameras.push_back(view.camera);
    return NearSilhouettes(loaded.cloud.points, cameras, ReadDepthMaps(depth, views, depth_unit),
                           silhouette);
  }

  void Run() const {
    options.Thresholds();  // a bad --tau is reported before large files are read
    const TriangleMesh measured = ReadMesh(mesh);
    const Truth loaded = ReadTruth(truth);
    const Evaluation evaluation = EvaluateMesh(measured, loaded, options, BoundaryFlags(loaded));
    if (json) {
      std::cout << ToJson(evaluation).dump(2) << "\n";
    } else {
      std::cout << EvaluationReport(evaluation);
    }
  }
};

}  // namespace

void AddEvaluateCommand(CLI::App* program) {
  CLI::App* app = program->add_subcommand("evaluate", "score a mesh against ground truth");
  const auto command = std::make_shared<EvaluateCommand>();
  command->options.Describe(&command->set);
  app->add_option("--mesh", command->mesh, "PLY, OBJ or OFF")
      ->option_text("FILE (required)")
      ->required();
  app->add_option("--truth", command->truth, "mesh, or PLY point cloud, best with normals")
      ->option_text("FILE (required)")
      ->required();
  app->add_option("--scene", command->scene,
                  "COLMAP workspace: with --depth, completeness also near occlusion boundaries and "
                  "in the rest")
      ->option_text("DIR");
  app->add_option(
         "--depth", command->depth,
         "true depth map of each view NAME.jpg: NAME.tiff (float) or NAME_depth.png (16 bit)")
      ->option_text("DIR");
  app->add_option("--depth_unit", command->depth_unit, "world units of 1 in a PNG depth map")
      ->check(CLI::PositiveNumber);
  app->add_option("--boundary_px", command->silhouette.radius_px,
                  "distance from a depth step that counts as near, pixels (default 4)")
      ->check(CLI::PositiveNumber);
  app->add_flag("--json", command->json, "print JSON");
  BindOptions(&command->set, app, {}, [command] { command->options.Thresholds(); });
  app->callback([command] { command->Run(); });
}

}  // namespace burin
