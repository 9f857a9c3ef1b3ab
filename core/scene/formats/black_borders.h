// Black that another program's undistortion has left around photographs: it is no picture of anything, and its edge is
// matched like one.
#pragma once

#include "core/scene/scene.h"

namespace burin {

// Of the views of one camera (as its format says, else of one size and intrinsics), three at least, the pixels that are
// exactly 0 in all of them and connected with the picture's border through such: when they are more than a thousandth of
// it, they are taken out of the views' masks, and a note says so. Views with a lens are undistorted by burin itself and
// have none.
void MaskBlackBorders(Scene* scene);

}  // namespace burin
