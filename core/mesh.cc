#include "core/mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <utility>

namespace burin {
namespace {

// Builds compressed rows from (row, value) pairs, sorted and without repeats.
Adjacency RowsFromPairs(std::vector<std::pair<int, int>> pairs, int row_count) {
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  Adjacency rows;
  rows.start.assign(row_count + 1, 0);
  rows.index.reserve(pairs.size());
  for (const auto& [row, value] : pairs) {
    ++rows.start[row + 1];
    rows.index.push_back(value);
  }
  for (int r = 0; r < row_count; ++r) rows.start[r + 1] += rows.start[r];
  return rows;
}

}  // namespace

Adjacency VertexNeighbors(const TriangleMesh& mesh) {
  std::vector<std::pair<int, int>> pairs;
  pairs.reserve(mesh.faces.size() * 6);
  for (const Eigen::Vector3i& face : mesh.faces) {
    for (int c = 0; c < 3; ++c) {
      pairs.emplace_back(face[c], face[(c + 1) % 3]);
      pairs.emplace_back(face[(c + 1) % 3], face[c]);
    }
  }
  return RowsFromPairs(std::move(pairs), static_cast<int>(mesh.vertices.size()));
}

Adjacency VertexFaces(const TriangleMesh& mesh) {
  std::vector<std::pair<int, int>> pairs;
  pairs.reserve(mesh.faces.size() * 3);
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    for (int c = 0; c < 3; ++c) pairs.emplace_back(mesh.faces[f][c], static_cast<int>(f));
  }
  return RowsFromPairs(std::move(pairs), static_cast<int>(mesh.vertices.size()));
}

Eigen::Vector3d FaceAreaNormal(const TriangleMesh& mesh, int face) {
  const Eigen::Vector3i& f = mesh.faces[face];
  const Eigen::Vector3d& origin = mesh.vertices[f[0]];
  return (mesh.vertices[f[1]] - origin).cross(mesh.vertices[f[2]] - origin);
}

std::vector<Eigen::Vector3d> VertexNormals(const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3d> normals(mesh.vertices.size(), Eigen::Vector3d::Zero());
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    const Eigen::Vector3d area_normal = FaceAreaNormal(mesh, static_cast<int>(f));
    for (int c = 0; c < 3; ++c) normals[mesh.faces[f][c]] += area_normal;
  }
  for (Eigen::Vector3d& normal : normals) {
    const double length = normal.norm();
    normal = length > 0 ? Eigen::Vector3d(normal / length) : Eigen::Vector3d::Zero();
  }
  return normals;
}

std::vector<char> BoundaryVertices(const TriangleMesh& mesh) {
  std::vector<std::array<int, 2>> edges;
  edges.reserve(mesh.faces.size() * 3);
  for (const Eigen::Vector3i& face : mesh.faces) {
    for (int c = 0; c < 3; ++c) {
      const int a = face[c];
      const int b = face[(c + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b)});
    }
  }
  std::sort(edges.begin(), edges.end());
  std::vector<char> on_boundary(mesh.vertices.size(), 0);
  for (size_t e = 0; e < edges.size();) {
    size_t end = e + 1;
    while (end < edges.size() && edges[end] == edges[e]) ++end;
    if (end - e == 1) on_boundary[edges[e][0]] = on_boundary[edges[e][1]] = 1;
    e = end;
  }
  return on_boundary;
}

Eigen::AlignedBox3d BoundingBox(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& vertex : mesh.vertices) box.extend(vertex);
  return box;
}

double BoundingDiagonal(const TriangleMesh& mesh) {
  return mesh.vertices.empty() ? 0.0 : BoundingBox(mesh).diagonal().norm();
}

}  // namespace burin
