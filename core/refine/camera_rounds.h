// Rounds that move the cameras with the surface: which they are, and what becomes of the views afterwards.
//
// Such a round's energy has the poses of the views as unknowns beside the vertices (core/solve/round_energy.h). It
// does not know the world's place, turn and size. They are taken out afterwards, from poses and vertices that moved, by
// the similarity that leaves the image of the surface where the cameras that the refinement began with have it
// (core/scene/camera_similarity.h). So vertices that do not move stay exactly.
//
// Tracks (core/cameras/track_step.h) measure cameras that they hold together in images of up to 2048 px; a round of small images knows them
// less well: cameras that tracks left .01 to .04 px off came out .05 to .2 px off where the level's images had 160 px, .03 px
// where they had 240. So such rounds are left out where the tracks' cameras are kept. They say how groups of views lie to
// each other, which tracks do not: with several groups they stay.
//
// The last round of a level moves the surface alone: it ends through the cameras that the judge sees it by.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/refine/normalized_world.h"
#include "core/refine/view_levels.h"
#include "core/scene/cameras_options.h"
#include "core/scene/pyramid.h"
#include "core/solve/energy_term.h"
#include "core/solve/solver_strategy.h"

namespace burin {

// The longer side of images whose rounds move cameras that tracks have put right.
constexpr int kLeastJointSidePx = 320;

// Levels of a run that move no cameras because their images are smaller.
struct SmallLevels {
  int finest = -1;     // -1: there is none
  double side_px = 0;  // of its largest image
  bool Any() const { return finest >= 0; }
};

// Of the levels whose rounds `options` let move cameras, up to the run's `first_level`: those of small images, which are
// taken out of `options`.
SmallLevels LeaveOutSmallLevels(const Scene& scene, const ViewLevels& levels, int first_level,
                                CamerasOptions* options);

// `rounds`: of the level.
bool MovesCameras(const CamerasOptions& options, int level, int round, int rounds);

// `type`, or lm_pcg where it cannot move cameras.
std::string StrategyForCameras(const std::string& type, int unknowns, const SolverOptions& options);

std::vector<CameraPose> PosesOf(const std::vector<LevelView>& views);

// Takes the world's motion from the solved `poses` and `vertices` (those that move in `context`, which is of the round's start), and
// gives the poses to `cameras`, those of the views in the caller's world. Returns by how many pixels of the level the surface's
// image moved: the root mean square over the views. `first`: those of the views as the refinement began. A camera that the solver did
// not move stays; so do all cameras and vertices when fewer than three points are seen.
double TakeCameras(const RoundContext& context, const std::vector<Camera>& first,
                   const NormalizedWorld& world, const std::vector<CameraPose>& poses,
                   std::vector<Eigen::Vector3d>* vertices, std::vector<Camera>* cameras);

}  // namespace burin
