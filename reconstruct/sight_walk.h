// Which cells a line of sight goes through, from the point that is seen.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "reconstruct/triangulation.h"

namespace burin {

class SightWalk {
 public:
  // Both must outlive it.
  SightWalk(const std::vector<Eigen::Vector3d>& points, const Tetrahedra& tetrahedra);

  // From `point` straight to `target`: step(cell, k) for each facet that is crossed, with the cell that is left and
  // its facet. The cell where the walk ends: with the target in it, or the infinite one where it leaves the hull.
  // -1 where a point has no cell, and where the line is lost among points that it touches.
  template <typename Step>
  int Walk(int point, const Eigen::Vector3d& target, const Step& step) const;

  // Distance from `point` along the unit vector `direction` to the plane of facet k of `cell`; positive, world units.
  double DistanceToFacet(int point, const Eigen::Vector3d& direction, int cell, int k) const;

 private:
  static constexpr int kMostSteps = 100000;

  // The cell at `point` that the way to `target` begins in, and its facet that it leaves through.
  int First(int point, const Eigen::Vector3d& target, int* exit) const;
  // The facet through which the line from `from` to `target`, come through facet `entry`, leaves the cell; -1: none.
  int Exit(int cell, int entry, const Eigen::Vector3d& from, const Eigen::Vector3d& target) const;
  // Whether `target` lies on the cell's side of its facet k, or on it.
  bool IsWithin(int cell, int k, const Eigen::Vector3d& target) const;

  const std::vector<Eigen::Vector3d>& points_;
  const Tetrahedra& tetrahedra_;
  PointCells around_;
};

template <typename Step>
int SightWalk::Walk(int point, const Eigen::Vector3d& target, const Step& step) const {
  int exit = -1;
  int cell = First(point, target, &exit);
  if (cell < 0 || exit < 0) return cell;
  for (int steps = 0; steps < kMostSteps; ++steps) {
    if (IsWithin(cell, exit, target)) return cell;
    step(cell, exit);
    const int next = tetrahedra_.neighbors[cell][exit];
    if (tetrahedra_.IsInfinite(next)) return next;
    exit = Exit(next, tetrahedra_.FacetTo(next, cell), points_[point], target);
    if (exit < 0) return -1;
    cell = next;
  }
  return -1;
}

}  // namespace burin
