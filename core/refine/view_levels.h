// At which levels of the pyramid a view takes part, and how often its photograph is halved there.
//
// A level is a size of pixels on the surface: 2^level times those of the view that sees a piece of it sharpest.
// A view with pixels up to twice as coarse is halved as often as that one; with pixels 2^k times as coarse, k
// above 1, it is halved k - 1 times less, but never enlarged. So the pixels of a level have like sizes on the
// surface, to a factor of two, where cameras, zooms and distances differ.
#pragma once

#include <vector>

#include "core/mesh/mesh.h"
#include "core/refine/refinement_options.h"
#include "core/scene/pairs.h"
#include "core/scene/pyramid.h"
#include "core/scene/scene.h"

namespace burin {

class ViewLevels {
 public:
  // Scene and mesh in the same world. The scene's images need not be loaded.
  ViewLevels(const Scene& scene, const TriangleMesh& mesh, const LevelOptions& options);

  // By view. A view takes part where its image has level.min_side_px; on the finest level all do.
  std::vector<ViewAtLevel> At(int level) const;

  // The coarsest of the levels asked for on which half of the pairs take part and, where some are held
  // back, one of those; or else the finest.
  int Coarsest(const std::vector<CameraPair>& pairs,
               const std::vector<CameraPair>& held_back) const;

 private:
  const LevelOptions options_;
  std::vector<int> side_;  // by view, the smaller one of its photograph
  std::vector<int> less_;  // by view, the halvings that it is spared
};

}  // namespace burin
