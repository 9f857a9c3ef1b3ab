#include "core/cameras/cameras_options.h"

namespace burin {

void CamerasOptions::Describe(OptionSet* set) {
  set->Add("cameras.refine", &refine,
           "What of the cameras is refined with the surface: none; poses = rotation and centre of "
           "every view");
}

}  // namespace burin
