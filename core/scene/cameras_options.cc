#include "core/scene/cameras_options.h"

namespace burin {

void CamerasOptions::Describe(OptionSet* set) {
  set->Add("cameras.refine", &refine,
           "What of the cameras is refined with the surface: none; poses = rotation and centre of "
           "every view");
  set->Add("cameras.steps", &steps,
           "How: tracks = before the first level, over tracks of windows matched through the mesh; "
           "joint = with the surface, in the photometric energy of rounds; both");
  set->Add("cameras.coarsest_joint", &coarsest_joint,
           "Coarsest level whose rounds, but the last, move cameras with the surface: 0 = full "
           "resolution, 1 = half, ...",
           0, 11);
}

}  // namespace burin
