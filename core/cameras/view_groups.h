// Views that tracks hold together. Two that share twelve tracks are in one group, and so are those that such
// views link; between groups nothing says how they lie to each other, and each gets a frame of its own
// (core/cameras/track_step.h). Fewer common tracks than twelve would be a hinge.
#pragma once

#include <vector>

#include "core/scene/tracks.h"

namespace burin {

constexpr int kFewestCommonTracks = 12;

struct ViewGroups {
  std::vector<int> of_view;  // its group, the first view's first; -1: in none
  int count = 0;
  std::vector<int> ViewsOf(int group) const;
};

// Measurements that tie a track to another group than most of its own, or to a view without one, are taken out of
// `tracks`, and so are the tracks that are left with one: `kept` has the numbers of the others.
ViewGroups GroupViews(int view_count, Tracks* tracks, std::vector<int>* kept);

}  // namespace burin
