#include "core/mesh/submesh.h"

namespace burin {

TriangleMesh WithoutFacets(const TriangleMesh& mesh, const std::vector<char>& cut,
                           std::vector<int>* vertices) {
  TriangleMesh part;
  std::vector<int> index(mesh.vertices.size(), -1);
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    if (cut[f] != 0) continue;
    part.faces.push_back(mesh.faces[f]);
    for (const int v : mesh.faces[f]) index[v] = 0;
  }
  vertices->clear();
  for (size_t v = 0; v < index.size(); ++v) {
    if (index[v] < 0) continue;
    index[v] = static_cast<int>(vertices->size());
    vertices->push_back(static_cast<int>(v));
    part.vertices.push_back(mesh.vertices[v]);
  }
  for (Eigen::Vector3i& face : part.faces) {
    for (int c = 0; c < 3; ++c) face[c] = index[face[c]];
  }
  return part;
}

}  // namespace burin
