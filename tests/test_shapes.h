// Small meshes with closed forms, for the tests of distances and scores.
#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "core/mesh/mesh.h"

namespace burin {

// n x n squares over [0, size]^2 at the height given by `height`, facing +z.
template <typename Height>
TriangleMesh Grid(int n, double size, const Height& height) {
  TriangleMesh mesh;
  for (int r = 0; r <= n; ++r) {
    for (int c = 0; c <= n; ++c) {
      const double x = size * c / n;
      const double y = size * r / n;
      mesh.vertices.emplace_back(x, y, height(x, y));
    }
  }
  for (int r = 0; r < n; ++r) {
    for (int c = 0; c < n; ++c) {
      const int a = r * (n + 1) + c;
      mesh.faces.emplace_back(a, a + 1, a + n + 2);
      mesh.faces.emplace_back(a, a + n + 2, a + n + 1);
    }
  }
  return mesh;
}

inline TriangleMesh Plane(double z, double size = 1.0, int n = 8) {
  return Grid(n, size, [&](double, double) { return z; });
}

inline TriangleMesh Relief(int n) {
  return Grid(n, 1.0, [](double x, double y) {
    return 0.2 * std::sin(5 * x + 1) * std::cos(4 * y) + 0.1 * x * x;
  });
}

// Octahedron split `levels` times onto the sphere, outward.
inline TriangleMesh Sphere(double radius, int levels) {
  TriangleMesh mesh;
  mesh.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.faces = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int level = 0; level < levels; ++level) {
    TriangleMesh finer;
    finer.vertices = mesh.vertices;
    for (const Eigen::Vector3i& f : mesh.faces) {
      const int a = static_cast<int>(finer.vertices.size());
      for (int c = 0; c < 3; ++c) {
        finer.vertices.push_back(
            (mesh.vertices[f[c]] + mesh.vertices[f[(c + 1) % 3]]).normalized());
      }
      finer.faces.emplace_back(f[0], a, a + 2);
      finer.faces.emplace_back(f[1], a + 1, a);
      finer.faces.emplace_back(f[2], a + 2, a + 1);
      finer.faces.emplace_back(a, a + 1, a + 2);
    }
    mesh = finer;
  }
  for (Eigen::Vector3d& vertex : mesh.vertices) vertex *= radius;
  return mesh;
}

}  // namespace burin
