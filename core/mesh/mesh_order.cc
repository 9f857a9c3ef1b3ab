#include "core/mesh/mesh_order.h"

#include <glog/logging.h>

#include <algorithm>
#include <cstdint>
#include <utility>

namespace burin {
namespace {

constexpr int kBits = 16;  // of the curve, along each axis

// The lowest kBits of `value`, two zeros between each.
uint64_t Spread(uint64_t value) {
  uint64_t spread = 0;
  for (int bit = 0; bit < kBits; ++bit) spread |= ((value >> bit) & 1) << (3 * bit);
  return spread;
}

}  // namespace

MeshOrder OrderAlongCurve(const TriangleMesh& mesh) {
  MeshOrder order;
  if (mesh.vertices.empty()) return order;
  const Eigen::AlignedBox3d box = BoundingBox(mesh);
  const double extent = box.sizes().maxCoeff();
  const double scale = extent > 0 ? ((1 << kBits) - 1) / extent : 0;
  std::vector<std::pair<uint64_t, int>> keys(mesh.faces.size());
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    const Eigen::Vector3i& face = mesh.faces[f];
    const Eigen::Vector3d centroid =
        (mesh.vertices[face[0]] + mesh.vertices[face[1]] + mesh.vertices[face[2]]) / 3;
    const Eigen::Vector3d cell = scale * (centroid - box.min());
    uint64_t key = 0;
    for (int c = 0; c < 3; ++c) key |= Spread(static_cast<uint64_t>(std::max(0.0, cell[c]))) << c;
    keys[f] = {key, static_cast<int>(f)};
  }
  std::sort(keys.begin(), keys.end());
  std::vector<char> used(mesh.vertices.size(), 0);
  order.vertex.reserve(mesh.vertices.size());
  order.face.reserve(mesh.faces.size());
  for (const auto& [key, face] : keys) {
    order.face.push_back(face);
    for (const int vertex : mesh.faces[face]) {
      if (used[vertex] == 0) order.vertex.push_back(vertex);
      used[vertex] = 1;
    }
  }
  for (size_t v = 0; v < used.size(); ++v) {
    if (used[v] == 0) order.vertex.push_back(static_cast<int>(v));
  }
  return order;
}

TriangleMesh Ordered(const TriangleMesh& mesh, const MeshOrder& order) {
  CHECK_EQ(order.vertex.size(), mesh.vertices.size());
  CHECK_EQ(order.face.size(), mesh.faces.size());
  TriangleMesh ordered;
  ordered.vertices.reserve(mesh.vertices.size());
  ordered.faces.reserve(mesh.faces.size());
  std::vector<int> index(mesh.vertices.size());
  for (size_t k = 0; k < order.vertex.size(); ++k) {
    ordered.vertices.push_back(mesh.vertices[order.vertex[k]]);
    index[order.vertex[k]] = static_cast<int>(k);
  }
  for (const int f : order.face) {
    const Eigen::Vector3i& face = mesh.faces[f];
    ordered.faces.emplace_back(index[face[0]], index[face[1]], index[face[2]]);
  }
  return ordered;
}

void RestoreVertices(const TriangleMesh& ordered, const MeshOrder& order, TriangleMesh* mesh) {
  CHECK_EQ(order.vertex.size(), mesh->vertices.size());
  for (size_t k = 0; k < order.vertex.size(); ++k) {
    mesh->vertices[order.vertex[k]] = ordered.vertices[k];
  }
}

}  // namespace burin
