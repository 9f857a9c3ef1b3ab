#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "apps/commands/command.h"
#include "apps/commands/commands.h"
#include "apps/commands/evaluate_options.h"
#include "core/evaluate/camera_evaluation.h"
#include "core/evaluate/evaluation_report.h"
#include "core/mesh/mesh_io.h"
#include "core/scene/formats/scene_loader.h"
#include "core/support/error.h"
#include "core/support/json_file.h"
#include "core/support/options.h"
#include "core/visibility/ray_render.h"
#include "core/visibility/silhouette.h"

namespace burin {
namespace {

std::string BoxText(const Eigen::AlignedBox3d& box) {
  std::ostringstream text;
  const Eigen::Vector3d size = box.sizes();
  const Eigen::Vector3d middle = box.center();
  text << size.x() << " x " << size.y() << " x " << size.z() << " around " << middle.x() << " "
       << middle.y() << " " << middle.z();
  return text.str();
}

std::string NothingMatched(const TriangleMesh& mesh, const Truth& truth, double max_distance) {
  Eigen::AlignedBox3d box = BoundingBox(truth.mesh);
  for (const Eigen::Vector3d& point : truth.cloud.points) box.extend(point);
  std::ostringstream reach;
  reach << max_distance;
  return "nothing matched: no point of either side is within " + reach.str() +
         " world units of the other; mesh " + BoxText(BoundingBox(mesh)) + ", truth " +
         BoxText(box) + " (metres against millimetres, other axes, another frame?)";
}

struct EvaluateCommand {
  EvaluateOptions options;
  OptionSet set;
  std::string mesh;
  std::string truth;
  std::string scene;
  std::string images;
  std::string depth;
  std::string cameras;
  double depth_unit = 1;
  SilhouetteOptions silhouette;
  bool json = false;

  // What contradicts itself is reported before large files are read.
  void Check() const {
    options.scores.Thresholds();
    if (!cameras.empty() && scene.empty()) {
      throw InputError("--cameras: needs --scene, whose cameras are to be compared");
    }
    if (truth.empty()) {
      const char* wanting = options.dtu.run       ? "dtu.run"
                            : options.strecha.run ? "strecha.run"
                            : !depth.empty()      ? "--depth"
                                                  : nullptr;
      if (wanting != nullptr) throw InputError(std::string(wanting) + ": needs --truth");
    }
    if (options.scores.align == AlignmentKind::kCameras) {
      if (cameras.empty()) {
        throw InputError(
            "align = cameras: needs --scene, in the mesh's frame, and --cameras, in the truth's");
      }
      if (options.strecha.run || !depth.empty()) {
        throw InputError(
            "align = cameras: --scene is in the mesh's frame, and strecha.run and --depth need it "
            "in the truth's");
      }
    }
    if (options.strecha.run && scene.empty()) {
      throw InputError("strecha.run: needs the cameras of --scene");
    }
    if (!options.strecha.run && options.strecha.sigma > 0) {
      throw InputError("strecha.sigma: needs strecha.run");
    }
    if (!options.strecha.run && cameras.empty() && scene.empty() != depth.empty()) {
      throw InputError("--scene and --depth: both or neither, they belong together");
    }
  }

  std::vector<char> BoundaryFlags(const Truth& loaded, const Scene& views,
                                  const std::vector<cv::Mat1f>& maps) const {
    if (maps.empty() || loaded.IsMesh()) return {};
    std::vector<Camera> cameras;
    for (const View& view : views.views) cameras.push_back(view.camera);
    return NearSilhouettes(loaded.cloud.points, cameras, maps, silhouette);
  }

  TruthDepth DepthOf(const Truth& loaded, const Scene& views,
                     const std::vector<cv::Mat1f>& maps) const {
    if (!maps.empty()) return [&maps](int view) { return maps[view]; };
    const auto rays = std::make_shared<MeshRays>(loaded.mesh);
    return [rays, &views](int view) { return RenderDepth(*rays, views.views[view].camera); };
  }

  void Score(const TriangleMesh& measured, const Truth& loaded, const Scene& views,
             const Scene& true_views, const DtuRegion& region, std::string* report,
             nlohmann::json* document, std::string* nothing) const {
    if (!depth.empty() && loaded.IsMesh() && !options.strecha.run) {
      throw InputError(truth, "must be a point cloud to split by --scene and --depth");
    }
    if (depth.empty() && !loaded.IsMesh() && options.strecha.run) {
      throw InputError(truth,
                       "is a point cloud: strecha.run needs a mesh, or depth maps by --depth");
    }
    std::vector<cv::Mat1f> maps;
    if (!depth.empty()) maps = ReadDepthMaps(depth, views, depth_unit);

    EvaluationOptions how = options.scores;
    if (how.align == AlignmentKind::kCameras) {
      how.truth_from_scene =
          EvaluateCameras(views, true_views, measured, /*on_truth=*/false).truth_from_scene;
    }
    const Evaluation scores =
        EvaluateMesh(measured, loaded, how, BoundaryFlags(loaded, views, maps));
    const double unit = options.scores.unit;
    const TriangleMesh moved = Moved(measured, scores.truth_from_mesh);
    *report = EvaluationReport(scores);
    *document = ToJson(scores);
    if (scores.accuracy.matched == 0 && scores.completeness.matched == 0) {
      *nothing = NothingMatched(moved, loaded, scores.max_distance);
    }
    if (options.dtu.run) {
      const DtuEvaluation dtu =
          EvaluateDtu(moved, loaded, options.dtu, region, unit, options.scores.seed);
      *report += DtuReport(dtu, unit);
      (*document)["dtu"] = ToJson(dtu);
    }
    if (options.strecha.run) {
      const DepthEvaluation depths =
          EvaluateDepth(moved, views, DepthOf(loaded, views, maps), options.strecha.sigma * unit);
      *report += DepthReport(depths, unit);
      (*document)["strecha"] = ToJson(depths);
    }
  }

  void Run() const {
    Check();
    const DtuRegion region = ReadDtuRegion(options.dtu);
    const TriangleMesh measured = ReadMesh(mesh);
    Scene views;
    if (!scene.empty()) views = LoadScene({scene, images, {}}, /*with_images=*/false);
    Scene true_views;
    if (!cameras.empty()) true_views = LoadScene({cameras, images, {}}, /*with_images=*/false);
    std::string report;
    std::string nothing;  // why there is no score
    nlohmann::json document = nlohmann::json::object();
    Truth loaded;
    if (!truth.empty()) {
      loaded = ReadTruth(truth);
      Score(measured, loaded, views, true_views, region, &report, &document, &nothing);
    }
    if (!cameras.empty()) {
      const bool on_truth = !truth.empty() && loaded.IsMesh();
      const CameraEvaluation errors =
          EvaluateCameras(views, true_views, on_truth ? loaded.mesh : measured, on_truth);
      report += CameraReport(errors, options.scores.unit);
      document["cameras"] = ToJson(errors);
    }
    std::cout << (json ? JsonText(document) : report);
    if (!nothing.empty()) throw InputError(nothing);
  }
};

}  // namespace

void AddEvaluateCommand(Program* program) {
  Command command = program->Add("evaluate", "score a mesh against ground truth");
  const auto state = std::make_shared<EvaluateCommand>();
  state->options.Describe(&state->set);
  command.Text("--mesh", "FILE (required)", &state->mesh, "PLY, OBJ, OFF or STL").Required();
  const Argument truth = command.Text("--truth", "FILE (required, but for --cameras)",
                                      &state->truth, "mesh, or PLY point cloud, best with normals");
  command.Text(
      "--scene", "SCENE", &state->scene,
      "scene, as burin refine reads it: for --cameras, in the mesh's frame; for --strecha.run, in "
      "the truth's; with --depth and a cloud, in the truth's too, completeness also near "
      "occlusion boundaries and in the rest");
  command.Text(
      "--cameras", "SCENE", &state->cameras,
      "true cameras of the same photographs, any scene that burin reads: errors of those of "
      "--scene in pixels, after a similarity, on the truth where it is a mesh, else on the mesh");
  command.Text("--images", "DIR", &state->images,
               "folder of the scene's photographs, where it is not its own");
  command.Text(
      "--depth", "DIR", &state->depth,
      "true depth map of each view NAME.jpg: NAME.tiff (float) or NAME_depth.png (16 bit)");
  command.Number("--depth_unit", &state->depth_unit, "world units of 1 in a PNG depth map")
      .Positive();
  command
      .Number("--boundary_px", &state->silhouette.radius_px,
              "distance from a depth step that counts as near, pixels (default 4)")
      .Positive();
  command.Flag("--json", &state->json, "print JSON");
  command.Options(&state->set, {}, [state] { state->options.scores.Thresholds(); });
  command.OnRun([state, truth] {
    if (state->cameras.empty() && !truth.Given()) truth.ThrowMissing();
    state->Run();
  });
}

}  // namespace burin
