#include "core/refine/camera_rounds.h"

#include <string>

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

std::vector<Camera> CamerasOf(const std::vector<LevelView>& views) {
  std::vector<Camera> cameras;
  for (const LevelView& view : views) cameras.push_back(view.camera);
  return cameras;
}

}  // namespace

bool MovesCameras(const CamerasOptions& options, int level, int round, int rounds) {
  return options.Jointly() && level <= options.coarsest_joint && level >= options.finest_joint &&
         round < options.joint_rounds && round + 1 < rounds;
}

std::vector<CameraPose> PosesOf(const std::vector<LevelView>& views) {
  std::vector<CameraPose> poses;
  for (const LevelView& view : views) poses.push_back(PoseOf(view.camera));
  return poses;
}

double TakeCameras(const RoundContext& context, const NormalizedWorld& world,
                   const std::vector<CameraPose>& poses, std::vector<Eigen::Vector3d>* vertices,
                   std::vector<Camera>* cameras) {
  const std::vector<Camera> before = CamerasOf(*context.views);
  std::vector<Camera> after = before;
  for (size_t v = 0; v < after.size(); ++v) SetPose(poses[v], &after[v]);
  CameraSimilarity fit;
  std::string error;
  if (!FitCameraSimilarity(before, after, PointsOf(context), &fit, &error)) return 0;
  const Similarity back = fit.second_from_first.Inverse();
  for (size_t v = 0; v < vertices->size(); ++v) {
    if (context.moves[v] != 0) (*vertices)[v] = back * (*vertices)[v];
  }
  for (size_t v = 0; v < after.size(); ++v) {
    const Camera moved = Moved(after[v], back);
    Camera& camera = (*cameras)[v];
    camera.rotation = moved.rotation;
    const Eigen::Vector3d center = world.origin + world.footprint * moved.Center();
    camera.translation = -(camera.rotation * center);
  }
  return fit.errors.rms_px;
}

}  // namespace burin
