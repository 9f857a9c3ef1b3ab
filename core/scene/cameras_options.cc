#include "core/scene/cameras_options.h"

namespace burin {

void CamerasOptions::Describe(OptionSet* set) {
  set->Add(
      "cameras.refine", &refine,
      "What of the cameras is refined with the surface: none; poses = rotation and centre of "
      "every view; poses_focal = also a factor of focal length a camera; poses_intrinsics = also "
      "focal length, principal point and the distortion that the camera model has; auto = poses, "
      "where tracks tell that they are better by more than they are uncertain");
  set->Add("cameras.steps", &steps,
           "How: tracks = before the first level, over tracks of windows matched through the mesh; "
           "joint = with the surface, in the photometric energy of rounds; both");
  set->Add("cameras.coarsest_joint", &coarsest_joint,
           "Coarsest level whose first rounds move cameras with the surface: 0 = full resolution, "
           "1 = half, ...",
           0, 11);
  set->Add(
      "cameras.finest_joint", &finest_joint,
      "Finest such level, as far as its rounds go: the last of a level moves the surface alone", 0,
      11);
  set->Add("cameras.joint_rounds", &joint_rounds, "Such rounds of a level", 1, 1000);
}

}  // namespace burin
