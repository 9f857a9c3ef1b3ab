// The nearest point of one triangle.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

namespace burin {

// Where on a triangle a point lies: inside, on edge c (from corner c to c+1), or at corner c.
enum class TriangleFeature { kFace, kEdge, kCorner };

struct TrianglePoint {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  double squared_distance = std::numeric_limits<double>::infinity();
  TriangleFeature feature = TriangleFeature::kFace;
  int which = 0;
};

// Triangles without area have no inside and are handled by their edges; an edge without length is a
// point.
inline TrianglePoint ClosestOnTriangle(const Eigen::Vector3d& query,
                                       const Eigen::Vector3d (&corners)[3]) {
  TrianglePoint best;
  const Eigen::Vector3d normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  const double squared_area = normal.squaredNorm();
  // Beyond which edges it lies: the nearest point is on one of these.
  bool beyond[3] = {true, true, true};
  if (squared_area > 0) {
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector3d edge = corners[(c + 1) % 3] - corners[c];
      beyond[c] = !(normal.dot(edge.cross(query - corners[c])) >= 0);
    }
  }
  if (!(beyond[0] || beyond[1] || beyond[2])) {
    const double height = normal.dot(query - corners[0]);
    best.point = query - (height / squared_area) * normal;
    best.squared_distance = height * height / squared_area;
    return best;
  }
  for (int c = 0; c < 3; ++c) {
    if (!beyond[c]) continue;
    const Eigen::Vector3d edge = corners[(c + 1) % 3] - corners[c];
    const double squared_length = edge.squaredNorm();
    double t = squared_length > 0 ? edge.dot(query - corners[c]) / squared_length : 0.0;
    t = std::min(1.0, std::max(0.0, t));
    const Eigen::Vector3d point = t < 1 ? corners[c] + t * edge : corners[(c + 1) % 3];
    const double squared_distance = (query - point).squaredNorm();
    if (squared_distance < best.squared_distance) {
      best.point = point;
      best.squared_distance = squared_distance;
      best.feature = t > 0 && t < 1 ? TriangleFeature::kEdge : TriangleFeature::kCorner;
      best.which = t < 1 ? c : (c + 1) % 3;
    }
  }
  return best;
}

}  // namespace burin
