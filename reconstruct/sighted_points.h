// Points of a surface with the views that see them: what a starting mesh is made of. Each view of a point is a line
// of sight, and says that there is nothing between its camera and the point.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/scene/scene.h"
#include "reconstruct/start_options.h"

namespace burin {

struct SightedPoints {
  std::vector<Eigen::Vector3d> positions;  // world units
  std::vector<double> footprints;  // the smallest of its views (Camera::Footprint), world units
  std::vector<int> begin = {0};    // of the views of each point, and the end of the last
  std::vector<int> views;          // indices into Scene::views, ascending within a point

  int Count() const { return static_cast<int>(positions.size()); }
  int SightCount(int point) const { return begin[point + 1] - begin[point]; }
  // `seen_by` ascending, without repeats, not empty.
  void Add(const Eigen::Vector3d& position, const std::vector<int>& seen_by,
           const std::vector<Camera>& cameras);
};

// How many sparse points a rule leaves out, each counted at the first that it breaks.
struct SparseReport {
  int points = 0;
  int without_views = 0;  // no view, or behind the camera of one
  int few_views = 0;
  int small_angle = 0;
  int large_error = 0;

  std::string Text() const;  // "1200 of 1500 sparse points: 200 seen by fewer than 3 views, ..."
  int Used() const { return points - without_views - few_views - small_angle - large_error; }
};

// The scene's sparse points that are well enough measured: see StartOptions. Throws InputError, saying why, where
// none is.
SightedPoints SparsePoints(const Scene& scene, const StartOptions& options, SparseReport* report);

// Points nearer to each other than `share` of the smaller footprint become one, the one that most views see (of
// equals, the first), with the views of all. Positions go to a lattice of about a thousandth of the median footprint:
// no three corners of a tetrahedron are then so nearly in a line that the area of their facet is rounding.
SightedPoints Merged(const SightedPoints& points, double share);

}  // namespace burin
