// Bodies with exact truth, finely cut, and what is measured of meshes that are made of them.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "core/mesh/mesh.h"
#include "tests/test_shapes.h"

namespace burin {

// Box over [0, size], closed, outward; its sides are cut into squares of side `step` and these in two.
inline TriangleMesh Box(const Eigen::Vector3i& cells, double step) {
  TriangleMesh mesh;
  std::map<std::array<int, 3>, int> index;
  const auto vertex = [&](const Eigen::Vector3i& at) {
    const auto [place, is_new] =
        index.try_emplace({at[0], at[1], at[2]}, static_cast<int>(mesh.vertices.size()));
    if (is_new) mesh.vertices.push_back(step * at.cast<double>());
    return place->second;
  };
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3;
    const int w = (axis + 2) % 3;
    for (int side = 0; side < 2; ++side) {
      for (int i = 0; i < cells[u]; ++i) {
        for (int j = 0; j < cells[w]; ++j) {
          int corner[4];
          const int offsets[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
          for (int c = 0; c < 4; ++c) {
            Eigen::Vector3i at;
            at[axis] = side * cells[axis];
            at[u] = i + offsets[c][0];
            at[w] = j + offsets[c][1];
            corner[c] = vertex(at);
          }
          if (side == 0) std::swap(corner[1], corner[3]);
          mesh.faces.emplace_back(corner[0], corner[1], corner[2]);
          mesh.faces.emplace_back(corner[0], corner[2], corner[3]);
        }
      }
    }
  }
  return mesh;
}

// Octahedron split `levels` times onto the sphere, closed, outward.
inline TriangleMesh RoundSphere(double radius, int levels) {
  const TriangleMesh parts = Sphere(radius, levels);  // its parts have vertices of their own
  TriangleMesh mesh;
  std::map<std::array<double, 3>, int> index;
  for (const Eigen::Vector3i& face : parts.faces) {
    Eigen::Vector3i corners;
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector3d& at = parts.vertices[face[c]];
      const auto [place, is_new] = index.try_emplace({at[0] + 0.0, at[1] + 0.0, at[2] + 0.0},
                                                     static_cast<int>(mesh.vertices.size()));
      if (is_new) mesh.vertices.push_back(at);
      corners[c] = place->second;
    }
    mesh.faces.push_back(corners);
  }
  return mesh;
}

// Round rod along z from 0 to `length`, closed, outward: `around` vertices to a ring, `rings` stretches.
inline TriangleMesh Rod(double radius, double length, int around, int rings) {
  TriangleMesh mesh;
  for (int r = 0; r <= rings; ++r) {
    for (int k = 0; k < around; ++k) {
      const double angle = 2 * M_PI * k / around;
      mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle),
                                 length * r / rings);
    }
  }
  const int bottom = static_cast<int>(mesh.vertices.size());
  mesh.vertices.emplace_back(0, 0, 0);
  mesh.vertices.emplace_back(0, 0, length);
  for (int k = 0; k < around; ++k) {
    const int next = (k + 1) % around;
    mesh.faces.emplace_back(bottom, next, k);
    mesh.faces.emplace_back(bottom + 1, rings * around + k, rings * around + next);
    for (int r = 0; r < rings; ++r) {
      const int row = r * around;
      mesh.faces.emplace_back(row + k, row + next, row + around + next);
      mesh.faces.emplace_back(row + k, row + around + next, row + around + k);
    }
  }
  return mesh;
}

inline double Volume(const TriangleMesh& mesh) {
  double sum = 0;
  for (const Eigen::Vector3i& face : mesh.faces) {
    sum += mesh.vertices[face[0]].dot(mesh.vertices[face[1]].cross(mesh.vertices[face[2]]));
  }
  return sum / 6;
}

inline double Area(const TriangleMesh& mesh) {
  double sum = 0;
  for (int f = 0; f < static_cast<int>(mesh.faces.size()); ++f)
    sum += FaceAreaNormal(mesh, f).norm();
  return sum / 2;
}

inline std::map<std::pair<int, int>, int> EdgeUses(const TriangleMesh& mesh) {
  std::map<std::pair<int, int>, int> uses;
  for (const Eigen::Vector3i& face : mesh.faces) {
    for (int c = 0; c < 3; ++c) ++uses[std::minmax({face[c], face[(c + 1) % 3]})];
  }
  return uses;
}

// Vertices - edges + facets. Vertices without facets do not count.
inline int EulerNumber(const TriangleMesh& mesh) {
  std::set<int> used;
  for (const Eigen::Vector3i& face : mesh.faces) used.insert(face.begin(), face.end());
  return static_cast<int>(used.size()) - static_cast<int>(EdgeUses(mesh).size()) +
         static_cast<int>(mesh.faces.size());
}

inline double BorderLength(const TriangleMesh& mesh) {
  double sum = 0;
  for (const auto& [edge, count] : EdgeUses(mesh)) {
    if (count == 1) sum += (mesh.vertices[edge.first] - mesh.vertices[edge.second]).norm();
  }
  return sum;
}

struct Shapes {
  double mean_quality = 0;      // 4 sqrt(3) area / sum of squared lengths
  double smallest_angle = 180;  // degrees
  double share_below_10 = 0;
  double mean_edge = 0;
};

inline Shapes MeasureShapes(const TriangleMesh& mesh) {
  Shapes shapes;
  const auto count = static_cast<double>(mesh.faces.size());
  for (const Eigen::Vector3i& face : mesh.faces) {
    double squares = 0;
    double smallest = 180;
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector3d& at = mesh.vertices[face[c]];
      const Eigen::Vector3d u = mesh.vertices[face[(c + 1) % 3]] - at;
      const Eigen::Vector3d v = mesh.vertices[face[(c + 2) % 3]] - at;
      squares += u.squaredNorm();
      smallest = std::min(smallest, std::atan2(u.cross(v).norm(), u.dot(v)) * 180 / M_PI);
      shapes.mean_edge += u.norm() / (3 * count);
    }
    const Eigen::Vector3d& origin = mesh.vertices[face[0]];
    const double area =
        (mesh.vertices[face[1]] - origin).cross(mesh.vertices[face[2]] - origin).norm() / 2;
    shapes.mean_quality += 4 * std::sqrt(3.0) * area / squares / count;
    shapes.smallest_angle = std::min(shapes.smallest_angle, smallest);
    shapes.share_below_10 += (smallest < 10 ? 1 : 0) / count;
  }
  return shapes;
}

}  // namespace burin
