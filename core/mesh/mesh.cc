#include "core/mesh/mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

#include "core/support/parallel.h"
#include "core/support/union_find.h"

namespace burin {
namespace {

constexpr int kVertexGrain = 2048;

// The vertices that the edges at v lead to, ascending, once for every face at the edge.
void EdgeEnds(const TriangleMesh& mesh, const Adjacency& faces, int v, std::vector<int>* ends) {
  ends->clear();
  for (const int* f = faces.Begin(v); f != faces.End(v); ++f) {
    for (const int w : mesh.faces[*f]) {
      if (w != v) ends->push_back(w);
    }
  }
  std::sort(ends->begin(), ends->end());
}

}  // namespace

Adjacency VertexNeighbors(const TriangleMesh& mesh, const Adjacency& faces) {
  const int count = static_cast<int>(mesh.vertices.size());
  std::vector<int> ends_of(2 * faces.index.size());  // from 2 * faces.start[v] on
  Adjacency neighbors;
  neighbors.start.assign(count + 1, 0);
  ParallelFor(count, kVertexGrain, [&](int begin, int end) {
    std::vector<int> ends;
    for (int v = begin; v < end; ++v) {
      EdgeEnds(mesh, faces, v, &ends);
      const auto last = std::unique(ends.begin(), ends.end());
      std::copy(ends.begin(), last, ends_of.begin() + 2 * static_cast<long>(faces.start[v]));
      neighbors.start[v + 1] = static_cast<int>(last - ends.begin());
    }
  });
  for (int v = 0; v < count; ++v) neighbors.start[v + 1] += neighbors.start[v];
  neighbors.index.resize(neighbors.start[count]);
  ParallelFor(count, kVertexGrain, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      std::copy_n(ends_of.begin() + 2 * static_cast<long>(faces.start[v]), neighbors.Degree(v),
                  neighbors.index.begin() + neighbors.start[v]);
    }
  });
  return neighbors;
}

Adjacency VertexFaces(const TriangleMesh& mesh) {
  const auto for_corners = [&mesh](const auto& visit) {
    for (size_t f = 0; f < mesh.faces.size(); ++f) {
      const Eigen::Vector3i& face = mesh.faces[f];
      visit(face[0], static_cast<int>(f));
      if (face[1] != face[0]) visit(face[1], static_cast<int>(f));
      if (face[2] != face[0] && face[2] != face[1]) visit(face[2], static_cast<int>(f));
    }
  };
  Adjacency faces;
  faces.start.assign(mesh.vertices.size() + 1, 0);
  for_corners([&](int v, int) { ++faces.start[v + 1]; });
  for (size_t v = 0; v < mesh.vertices.size(); ++v) faces.start[v + 1] += faces.start[v];
  faces.index.resize(faces.start.back());
  std::vector<int> next(faces.start.begin(), faces.start.end() - 1);
  for_corners([&](int v, int f) { faces.index[next[v]++] = f; });
  return faces;
}

Eigen::Vector3d FaceAreaNormal(const TriangleMesh& mesh, int face) {
  const Eigen::Vector3i& f = mesh.faces[face];
  const Eigen::Vector3d& origin = mesh.vertices[f[0]];
  return (mesh.vertices[f[1]] - origin).cross(mesh.vertices[f[2]] - origin);
}

std::vector<Eigen::Vector3d> VertexNormals(const TriangleMesh& mesh, const Adjacency& faces) {
  const int count = static_cast<int>(mesh.vertices.size());
  std::vector<Eigen::Vector3d> normals(count, Eigen::Vector3d::Zero());
  ParallelFor(count, kVertexGrain, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (const int* f = faces.Begin(v); f != faces.End(v); ++f) sum += FaceAreaNormal(mesh, *f);
      const double length = sum.norm();
      if (length > 0) normals[v] = sum / length;
    }
  });
  return normals;
}

std::vector<char> BoundaryVertices(const TriangleMesh& mesh, const Adjacency& faces) {
  const int count = static_cast<int>(mesh.vertices.size());
  std::vector<char> on_boundary(count, 0);
  ParallelFor(count, kVertexGrain, [&](int begin, int end) {
    std::vector<int> ends;
    for (int v = begin; v < end; ++v) {
      EdgeEnds(mesh, faces, v, &ends);
      for (size_t k = 0; k < ends.size() && on_boundary[v] == 0;) {
        size_t next = k + 1;
        while (next < ends.size() && ends[next] == ends[k]) ++next;
        if (next - k == 1) on_boundary[v] = 1;
        k = next;
      }
    }
  });
  return on_boundary;
}

Eigen::AlignedBox3d BoundingBox(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3i& face : mesh.faces) {
    for (const int v : face) box.extend(mesh.vertices[v]);
  }
  if (mesh.faces.empty()) {
    for (const Eigen::Vector3d& vertex : mesh.vertices) box.extend(vertex);
  }
  return box;
}

double BoundingDiagonal(const TriangleMesh& mesh) {
  return mesh.vertices.empty() ? 0.0 : BoundingBox(mesh).diagonal().norm();
}

std::vector<std::vector<int>> ConnectedComponents(const TriangleMesh& mesh) {
  std::vector<int> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0);
  for (const Eigen::Vector3i& face : mesh.faces) {
    for (int c = 0; c < 3; ++c) {
      parent[FindRoot(&parent, face[c])] = FindRoot(&parent, face[(c + 1) % 3]);
    }
  }
  std::vector<std::vector<int>> components;
  std::vector<int> index(mesh.vertices.size(), -1);  // by root
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    int& component = index[FindRoot(&parent, mesh.faces[f][0])];
    if (component < 0) {
      component = static_cast<int>(components.size());
      components.emplace_back();
    }
    components[component].push_back(static_cast<int>(f));
  }
  return components;
}

}  // namespace burin
