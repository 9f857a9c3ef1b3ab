// Where windows of the photographs are looked at, and the map that a facet's plane makes from a window of
// one photograph to another: what window_matches.h and free_space.h share.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "core/evidence/match_grid.h"
#include "core/mesh/mesh.h"
#include "core/scene/pairs.h"
#include "core/scene/scene.h"
#include "core/visibility/facet_rays.h"

namespace burin {

constexpr double kLeastContrast = 4;  // standard deviation of a window that counts, grey levels

// A photograph at the size that is looked at.
struct SmallView {
  Camera camera;
  cv::Mat1f image;
  cv::Mat1b whole;  // a window around the pixel has no masked one; empty = no mask
  Eigen::Vector2d pixel = {
      1, 1};  // pixels of the photograph to one of the image, by axis: sizes are rounded

  Eigen::Vector2d InPhotograph(const Eigen::Vector2d& at) const { return at.cwiseProduct(pixel); }
  bool MayHoldWindow(const Eigen::Vector2d& at) const;
};

// Halved until it has at most `largest_side_px`.
SmallView Reduce(const View& view, int largest_side_px);

// A window's centre, on the surface.
struct WindowPlace {
  Eigen::Vector2d at;
  int facet = -1;
  float texture = 0;
  Eigen::Vector3d point;
  uint64_t order = 0;  // random
};

// The most textured place of every square of a grid that makes about `count` squares of what the view sees
// of the mesh. `index` is the view's.
std::vector<WindowPlace> PlacesOf(const TriangleMesh& mesh, const SmallView& view, int index,
                                  int count);

constexpr int kFirstPartners = 4;

// The first partners that `pairs` gives each view, in their order; photographs with less than
// kLeastSidePx take no part.
std::vector<CameraPair> FirstPartners(const Scene& scene, const std::vector<CameraPair>& pairs,
                                      int count = kFirstPartners);

// Those of `places` that view j has inside, unmasked and not hidden by the mesh, by their index. `facing`:
// FacingFacets() of j's centre.
std::vector<int> PlacesSeenFrom(const FacetRays& rays, const SmallView& j,
                                const std::vector<uint8_t>& facing,
                                const std::vector<WindowPlace>& places);

// A window's samples in i, and in j through a plane: axes along and across the epipolar line.
struct WarpedWindow {
  SampleGrid at_i;
  SampleGrid at_j;
};

// Of the window around image point `at` of i, whose ray meets a plane of that unit normal in `point`. Nothing
// where the plane is seen under more than 80 degrees, the cosine of the parallax is below `least_cosine`, or
// the window would grow or shrink too much.
std::optional<WarpedWindow> WarpThroughPlane(const SmallView& i, const SmallView& j,
                                             const Eigen::Vector2d& at,
                                             const Eigen::Vector3d& point,
                                             const Eigen::Vector3d& normal, double least_cosine);

}  // namespace burin
