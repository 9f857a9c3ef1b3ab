#include "reconstruct/sight_walk.h"

#include <cmath>

namespace burin {

SightWalk::SightWalk(const std::vector<Eigen::Vector3d>& points, const Tetrahedra& tetrahedra)
    : points_(points),
      tetrahedra_(tetrahedra),
      around_(tetrahedra, static_cast<int>(points.size())) {}

bool SightWalk::IsWithin(int cell, int k, const Eigen::Vector3d& target) const {
  const std::array<int, 3> facet = tetrahedra_.Facet(cell, k);  // from outside
  return Orientation(points_[facet[0]], points_[facet[1]], points_[facet[2]], target) <= 0;
}

int SightWalk::First(int point, const Eigen::Vector3d& target, int* exit) const {
  int leaves = -1;  // the infinite cell that the target lies in
  for (const int* c = around_.Begin(point); c != around_.End(point); ++c) {
    const int infinite = tetrahedra_.CornerOf(*c, Tetrahedra::kInfinite);
    if (infinite >= 0) {
      // Its one finite facet, seen from the infinite side: the target is above where the hull is left.
      if (leaves < 0 &&
          !IsWithin(tetrahedra_.neighbors[*c][infinite],
                    tetrahedra_.FacetTo(tetrahedra_.neighbors[*c][infinite], *c), target)) {
        leaves = *c;
      }
      continue;
    }
    const int apex = tetrahedra_.CornerOf(*c, point);
    bool in_cone = true;
    for (int k = 0; k < 4 && in_cone; ++k) in_cone = k == apex || IsWithin(*c, k, target);
    if (!in_cone) continue;
    *exit = apex;
    return *c;
  }
  return leaves;
}

int SightWalk::Exit(int cell, int entry, const Eigen::Vector3d& from,
                    const Eigen::Vector3d& target) const {
  // The line goes through the entry facet e0 e1 e2, which is counter-clockwise seen from where it comes. It leaves
  // through the facet of the apex and the edge e_x e_y around which the apex' edges have it between them.
  const Eigen::Vector3d& apex = points_[tetrahedra_.corners[cell][entry]];
  const std::array<int, 3> facet = tetrahedra_.Facet(cell, entry);
  int side[3];
  for (int j = 0; j < 3; ++j) side[j] = Orientation(from, target, apex, points_[facet[j]]);
  for (int x = 0; x < 3; ++x) {
    if (side[x] <= 0 && side[(x + 1) % 3] >= 0) {
      return tetrahedra_.CornerOf(cell, facet[(x + 2) % 3]);
    }
  }
  return -1;
}

double SightWalk::DistanceToFacet(int point, const Eigen::Vector3d& direction, int cell,
                                  int k) const {
  const std::array<int, 3> facet = tetrahedra_.Facet(cell, k);
  const Eigen::Vector3d& a = points_[facet[0]];
  const Eigen::Vector3d normal = (points_[facet[1]] - a).cross(points_[facet[2]] - a);
  const double along = direction.dot(normal);
  return along != 0 ? std::abs((a - points_[point]).dot(normal) / along) : 0;
}

}  // namespace burin
