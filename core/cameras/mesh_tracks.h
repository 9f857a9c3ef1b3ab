// Tracks through the mesh: where several photographs show the same place of the surface.
//
// A textured 11x11 window of a view is warped through the mesh into up to six partners, as the verdict's are
// (core/evidence/window_matches.h), and its best match is looked for up to 20 px along and 8 px across the
// epipolar line, in images of at most `largest_side_px`. A match counts when its ZNCC is above .7 and by .05 above every other
// place's. A window with a partner's match is a track: its centre in its own view, the matches in
// the others. A rough mesh is good enough: it chooses the windows and brings the search near. (Two views say across
// the epipolar line only how their cameras lie, but views far apart have few windows that a third one shows.)
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <vector>

#include "core/cameras/view_groups.h"
#include "core/evidence/window_matches.h"
#include "core/mesh/mesh.h"
#include "core/scene/pairs.h"
#include "core/scene/scene.h"
#include "core/scene/tracks.h"

namespace burin {

struct MeshTracks {
  std::vector<Eigen::Vector3d> points;  // on the mesh, world
  // So many of them; then sparse points of the scene.
  size_t windows = std::numeric_limits<size_t>::max();
  Tracks tracks;  // pixels of the photographs; a window's own view first
  std::vector<double>
      pixel;  // of every view: pixels of the photograph to one of the image searched
  ViewGroups groups;
  // How much less sure the places of sparse points are than those of windows; AdjustBundle() finds it.
  double sparse_scale = 1;

  // What residuals of a track are divided by, pixels of the photograph.
  double ScaleOf(size_t track, int view) const {
    return pixel[view] * (track < windows ? 1 : sparse_scale);
  }
};

// Of pairs that FirstPartners() leaves of `pairs`, kMatchingPartners a view. The same for any number of threads.
MeshTracks FindMeshTracks(const Scene& scene, const TriangleMesh& mesh,
                          const std::vector<CameraPair>& pairs, int largest_side_px = kMatchSidePx);

}  // namespace burin
