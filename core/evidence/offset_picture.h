// A picture of the matches of core/evidence/window_matches.h, a panel a view.
#pragma once

#include <opencv2/core.hpp>

#include "core/evidence/verdict.h"
#include "core/scene/scene.h"

namespace burin {

// Of every view its matches as reference: how far along (to the right, 20 px to both sides) and across
// (down, 8 px) the epipolar line the best one lies from the place predicted. Clear matches are dark, others
// light, those with a view that does not fit light red. Right cameras give a horizontal line through the middle, a mesh that fits a dot in it.
cv::Mat3b OffsetPicture(const SceneVerdict& verdict, const Scene& scene);

}  // namespace burin
