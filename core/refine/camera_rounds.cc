#include "core/refine/camera_rounds.h"

#include <algorithm>
#include <cmath>

#include "core/scene/camera_similarity.h"

namespace burin {
namespace {

constexpr size_t kPoints = 1500;  // a view

// Corners of facets that the views see, in the world of the round's start.
std::vector<std::vector<Eigen::Vector3d>> PointsOf(const RoundContext& context) {
  std::vector<std::vector<Eigen::Vector3d>> points(context.domains->size());
  for (size_t v = 0; v < points.size(); ++v) {
    const std::vector<int>& facets = (*context.domains)[v].facet;
    const size_t step = 1 + facets.size() / kPoints;
    for (size_t k = 0; k < facets.size(); k += step) {
      points[v].push_back(context.mesh->vertices[context.mesh->faces[facets[k]][0]]);
    }
  }
  return points;
}

double LongestSide(const Scene& scene, const std::vector<ViewAtLevel>& views) {
  double longest = 0;
  for (size_t v = 0; v < views.size(); ++v) {
    const Camera& camera = scene.views[v].camera;
    if (!views[v].takes_part) continue;
    longest =
        std::max(longest, std::ldexp(std::max(camera.width, camera.height), -views[v].halvings));
  }
  return longest;
}

}  // namespace

SmallLevels LeaveOutSmallLevels(const Scene& scene, const ViewLevels& levels, int first_level,
                                CamerasOptions* options) {
  SmallLevels small;
  if (!options->Jointly()) return small;
  int level = std::min(options->coarsest_joint, first_level);
  for (; level >= options->finest_joint; --level) {
    const double side = LongestSide(scene, levels.At(level));
    if (side >= kLeastJointSidePx) break;
    small.finest = level;
    small.side_px = side;
  }
  if (!small.Any()) return small;
  options->coarsest_joint = level;
  if (level < options->finest_joint) options->steps = CameraSteps::kTracks;
  return small;
}

bool MovesCameras(const CamerasOptions& options, int level, int round, int rounds) {
  return options.Jointly() && level <= options.coarsest_joint && level >= options.finest_joint &&
         round < options.joint_rounds && round + 1 < rounds;
}

std::string StrategyForCameras(const std::string& type, int unknowns,
                               const SolverOptions& options) {
  const Strategy* strategy = FindStrategy(type, unknowns, options);
  return strategy == nullptr || strategy->moves_cameras ? type : "lm_pcg";
}

std::vector<CameraPose> PosesOf(const std::vector<LevelView>& views) {
  std::vector<CameraPose> poses;
  poses.reserve(views.size());
  for (const LevelView& view : views) poses.push_back(PoseOf(view.camera));
  return poses;
}

double TakeCameras(const RoundContext& context, const std::vector<Camera>& first,
                   const NormalizedWorld& world, const std::vector<CameraPose>& poses,
                   std::vector<Eigen::Vector3d>* vertices, std::vector<Camera>* cameras) {
  std::vector<Camera> reference;
  std::vector<Camera> before;
  std::vector<Camera> after;
  for (size_t v = 0; v < poses.size(); ++v) {
    const Camera& camera = (*context.views)[v].camera;
    reference.push_back(world.FromWorld(first[v], camera.width, camera.height));
    before.push_back(camera);
    SetPose(poses[v], &after.emplace_back(camera));
  }
  const std::vector<std::vector<Eigen::Vector3d>> points = PointsOf(context);
  CameraSimilarity motion;
  CameraSimilarity fit;
  std::string error;
  if (!FitCameraSimilarity(before, after, points, &motion, &error) ||
      !FitCameraSimilarity(reference, after, points, &fit, &error)) {
    *vertices = context.mesh->vertices;
    return 0;
  }
  const Similarity back = fit.second_from_first.Inverse();
  for (size_t v = 0; v < vertices->size(); ++v) {
    if (context.moves[v] != 0) (*vertices)[v] = back * (*vertices)[v];
  }
  for (size_t v = 0; v < after.size(); ++v) {
    if (poses[v] == PoseOf(before[v])) continue;
    const Camera moved = Moved(after[v], back);
    Camera& camera = (*cameras)[v];
    camera.rotation = moved.rotation;
    const Eigen::Vector3d center = world.origin + world.footprint * moved.Center();
    camera.translation = -(camera.rotation * center);
  }
  return motion.errors.rms_px;
}

}  // namespace burin
