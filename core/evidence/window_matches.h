// Where textured windows of the photographs find their best match in other photographs, beside the place
// where the surface sends them. What the verdict (core/evidence/verdict.h) is made of.
//
// An 11x11 window of view i is warped into view j by the affine map that the surface's plane at its
// centre makes. Around the place predicted, ZNCC is taken on a grid whose axes lie along and across the
// epipolar line, 20 px to both sides along it and 8 px across. The images are halved until they have at most
// `largest_side_px`. One px of the grid is one pixel of the reduced image i.
//
// Windows are looked at under a parallax of up to 35 degrees: beyond, photographs of a coarse mesh's facets
// differ by more than an affine map. Only where that leaves fewer than 30, those under a larger one are
// looked at too.
//
// Cost: a tenth of a millisecond a window. Of each pair up to 40 windows are looked at, well spread over
// what both views see; fewer, but 12 at least, in scenes of more than 150 pairs.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/pairs.h"
#include "core/scene/scene.h"

namespace burin {

constexpr int kMatchAcross = 8;     // the grid, to each side, px
constexpr int kMatchAlong = 20;     // the same along the line
constexpr int kChancePlaces = 8;    // a window
constexpr int kMatchSidePx = 1024;  // images are reduced to at most this
constexpr int kLeastSidePx = 300;   // of a photograph's longer side: below it chance is too near

struct WindowMatch {
  int reference = -1;     // i
  int second = -1;        // j
  Eigen::Vector2d place;  // of its centre, image point of photograph i
  double scale = 1;       // pixels of photograph i to one px of the grid
  double along = 0;       // best match, px of the grid from the place predicted, between its points
  double across = 0;
  int row = 0;              // whole px across, of the best match
  bool clear = false;       // it is inside the grid, and its ZNCC above .6
  float at_prediction = 0;  // ZNCC
  std::array<float, kChancePlaces> by_chance =
      {};  // at places 15 to 60 px away; NaN = off the image
};

// Windows of FirstPartners(scene, pairs). Image masks: a window has no masked pixel, and neither has its place predicted.
std::vector<WindowMatch> MatchWindows(const Scene& scene, const TriangleMesh& mesh,
                                      const std::vector<CameraPair>& pairs,
                                      int largest_side_px = kMatchSidePx);

}  // namespace burin
