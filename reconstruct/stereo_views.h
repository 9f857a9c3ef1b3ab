// Depth maps of all views of a scene.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "core/scene/scene.h"
#include "reconstruct/stereo_depth.h"
#include "reconstruct/stereo_pairs.h"

namespace burin {

struct StereoViewsRules {
  StereoRules pairs;
  int agreeing_pairs = 2;  // that a depth needs
  std::filesystem::path
      folder;  // where depth maps are kept (reconstruct/depth_files.h); empty: nowhere
};

struct StereoViews {
  std::vector<FusedDepth> depths;  // by view; without a map where it has no partners
  int matched = 0;                 // views that have a map
  int read = 0;                    // of these, from files
};

// `between(share)` is called between views, with the share that is done; it may throw.
StereoViews MatchViews(const Scene& scene, const StereoViewsRules& rules,
                       const std::function<void(double share)>& between);

}  // namespace burin
