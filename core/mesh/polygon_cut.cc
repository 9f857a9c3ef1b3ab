#include "core/mesh/polygon_cut.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

namespace burin {
namespace {

using Points = std::vector<Eigen::Vector2d>;

// Twice the area of the triangle, above 0 where it turns left.
double Turn(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

// In the plane across the vector of the polygon's area, in which it goes round to the left.
Points Projected(const std::vector<Eigen::Vector3d>& corners) {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (size_t k = 0; k < corners.size(); ++k) {
    normal += (corners[k] - corners[0]).cross(corners[(k + 1) % corners.size()] - corners[0]);
  }
  const Eigen::Quaterniond turn =
      Eigen::Quaterniond::FromTwoVectors(normal, Eigen::Vector3d::UnitZ());
  Points points;
  points.reserve(corners.size());
  for (const Eigen::Vector3d& corner : corners) {
    points.emplace_back((turn * (corner - corners[0])).head<2>());
  }
  return points;
}

bool IsConvex(const Points& points) {
  for (size_t k = 0; k < points.size(); ++k) {
    const size_t next = (k + 1) % points.size();
    if (Turn(points[k], points[next], points[(k + 2) % points.size()]) < 0) return false;
  }
  return true;
}

// Whether the triangle before, at, after turns left and has no other corner of what is left in it.
bool IsEar(const Points& points, const std::vector<int>& left, size_t k) {
  const int before = left[(k + left.size() - 1) % left.size()];
  const int at = left[k];
  const int after = left[(k + 1) % left.size()];
  if (!(Turn(points[before], points[at], points[after]) > 0)) return false;
  return std::none_of(left.begin(), left.end(), [&](int other) {
    const Eigen::Vector2d& p = points[other];
    if (p == points[before] || p == points[at] || p == points[after]) return false;
    return Turn(points[before], points[at], p) >= 0 && Turn(points[at], points[after], p) >= 0 &&
           Turn(points[after], points[before], p) >= 0;
  });
}

}  // namespace

std::vector<Eigen::Vector3i> CutPolygon(const std::vector<Eigen::Vector3d>& corners) {
  std::vector<int> left(corners.size());
  std::iota(left.begin(), left.end(), 0);
  std::vector<Eigen::Vector3i> triangles;
  const Points points = corners.size() > 3 ? Projected(corners) : Points();
  bool ears = corners.size() > 3 && !IsConvex(points);
  while (ears && left.size() > 3) {
    ears = false;
    for (size_t k = 0; k < left.size() && !ears; ++k) {
      if (!IsEar(points, left, k)) continue;
      triangles.emplace_back(left[(k + left.size() - 1) % left.size()], left[k],
                             left[(k + 1) % left.size()]);
      left.erase(left.begin() + static_cast<std::ptrdiff_t>(k));
      ears = true;
    }
  }
  for (size_t k = 2; k < left.size(); ++k) triangles.emplace_back(left[0], left[k - 1], left[k]);
  return triangles;
}

}  // namespace burin
