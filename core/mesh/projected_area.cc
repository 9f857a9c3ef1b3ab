#include "core/mesh/projected_area.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace burin {
namespace {

// A convex polygon in homogeneous image coordinates; each of the five planes adds one vertex at
// most.
struct Polygon {
  std::array<Eigen::Vector3d, 8> corner;
  int count = 0;
};

// The half space plane . x >= offset.
struct HalfSpace {
  Eigen::Vector3d plane;
  double offset = 0;
  double Inside(const Eigen::Vector3d& x) const { return plane.dot(x) - offset; }
};

// The part of `polygon` in the half space.
Polygon Clip(const Polygon& polygon, const HalfSpace& half_space) {
  Polygon inside;
  for (int c = 0; c < polygon.count; ++c) {
    const Eigen::Vector3d& from = polygon.corner[c];
    const Eigen::Vector3d& to = polygon.corner[(c + 1) % polygon.count];
    const double from_side = half_space.Inside(from);
    const double to_side = half_space.Inside(to);
    if (from_side >= 0) inside.corner[inside.count++] = from;
    if ((from_side < 0) != (to_side < 0) && inside.count < 8) {
      const double share = from_side / (from_side - to_side);
      inside.corner[inside.count++] = from + share * (to - from);
    }
    if (inside.count == 8) break;
  }
  return inside;
}

}  // namespace

double ProjectedArea(const Eigen::Matrix<double, 3, 4>& projection, int width, int height,
                     double near_depth, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                     const Eigen::Vector3d& c) {
  Polygon polygon;
  polygon.count = 3;
  polygon.corner[0] = projection.leftCols<3>() * a + projection.col(3);
  polygon.corner[1] = projection.leftCols<3>() * b + projection.col(3);
  polygon.corner[2] = projection.leftCols<3>() * c + projection.col(3);
  // Inside all four planes implies depth >= 0, since width * z is the sum of the first two.
  const std::array<HalfSpace, 5> half_spaces = {HalfSpace{Eigen::Vector3d(1, 0, 0)},
                                                {Eigen::Vector3d(-1, 0, width)},
                                                {Eigen::Vector3d(0, 1, 0)},
                                                {Eigen::Vector3d(0, -1, height)},
                                                {Eigen::Vector3d(0, 0, 1), near_depth}};
  for (const HalfSpace& half_space : half_spaces) {
    int inside_count = 0;
    for (int k = 0; k < polygon.count; ++k) {
      inside_count += static_cast<int>(half_space.Inside(polygon.corner[k]) >= 0);
    }
    if (inside_count == 0) return 0;
    if (inside_count < polygon.count) polygon = Clip(polygon, half_space);
  }
  std::array<Eigen::Vector2d, 8> image;
  for (int k = 0; k < polygon.count; ++k) {
    if (!(polygon.corner[k].z() > 0)) return 0;  // the face goes through the camera centre
    image[k] = polygon.corner[k].head<2>() / polygon.corner[k].z();
  }
  double twice_area = 0;
  for (int k = 2; k < polygon.count; ++k) {
    const Eigen::Vector2d u = image[k - 1] - image[0];
    const Eigen::Vector2d v = image[k] - image[0];
    twice_area += u.x() * v.y() - u.y() * v.x();
  }
  return 0.5 * std::abs(twice_area);
}

double ProjectedArea(const Camera& camera, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                     const Eigen::Vector3d& c) {
  return ProjectedArea(camera.ProjectionMatrix(), camera.width, camera.height, camera.near_depth, a,
                       b, c);
}

bool FacesCamera(const TriangleMesh& mesh, int face, const Camera& camera) {
  return FaceAreaNormal(mesh, face).dot(camera.Center() - mesh.vertices[mesh.faces[face][0]]) > 0;
}

double SharpestArea(const TriangleMesh& mesh, int face, const std::vector<Camera>& cameras) {
  double largest = 0;
  const Eigen::Vector3i& f = mesh.faces[face];
  for (const Camera& camera : cameras) {
    if (!FacesCamera(mesh, face, camera)) continue;
    largest = std::max(largest, ProjectedArea(camera, mesh.vertices[f[0]], mesh.vertices[f[1]],
                                              mesh.vertices[f[2]]));
  }
  return largest;
}

}  // namespace burin
