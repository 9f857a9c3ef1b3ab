#include "core/mesh/mesh_check.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/support/union_find.h"

namespace burin {
namespace {

struct EdgeUse {
  int low, high;  // vertices, low < high
  int face;
  int side;      // of the face: from its corner `side` to the next
  bool forward;  // the face goes from low to high
};

// All uses of all edges, those of one edge next to each other and by ascending face.
std::vector<EdgeUse> SortedEdgeUses(const TriangleMesh& mesh) {
  std::vector<EdgeUse> uses;
  uses.reserve(mesh.faces.size() * 3);
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    for (int c = 0; c < 3; ++c) {
      const int a = mesh.faces[f][c];
      const int b = mesh.faces[f][(c + 1) % 3];
      uses.push_back({std::min(a, b), std::max(a, b), static_cast<int>(f), c, a < b});
    }
  }
  std::sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) {
    if (a.low != b.low) return a.low < b.low;
    if (a.high != b.high) return a.high < b.high;
    return a.face < b.face;
  });
  return uses;
}

size_t EdgeEnd(const std::vector<EdgeUse>& uses, size_t begin) {
  size_t end = begin + 1;
  while (end < uses.size() && uses[end].low == uses[begin].low &&
         uses[end].high == uses[begin].high) {
    ++end;
  }
  return end;
}

// Not finite is zero.
bool HasZeroArea(const TriangleMesh& mesh, int f) {
  double longest_squared = 0;
  for (int c = 0; c < 3; ++c) {
    const Eigen::Vector3i& face = mesh.faces[f];
    longest_squared = std::max(
        longest_squared, (mesh.vertices[face[c]] - mesh.vertices[face[(c + 1) % 3]]).squaredNorm());
  }
  return !(FaceAreaNormal(mesh, f).norm() > 1e-12 * longest_squared);
}

template <typename Container>
int CountRepeats(const Container& sorted) {
  int repeats = 0;
  for (size_t i = 1; i < sorted.size(); ++i) repeats += sorted[i] == sorted[i - 1];
  return repeats;
}

}  // namespace

MeshReport CheckMesh(const TriangleMesh& mesh) {
  MeshReport report;
  report.vertex_count = static_cast<int>(mesh.vertices.size());
  report.face_count = static_cast<int>(mesh.faces.size());

  std::vector<std::array<double, 3>> positions;
  positions.reserve(mesh.vertices.size());
  for (const Eigen::Vector3d& v : mesh.vertices) positions.push_back({v.x(), v.y(), v.z()});
  std::sort(positions.begin(), positions.end());
  report.duplicate_vertex_count = CountRepeats(positions);

  std::vector<std::array<int, 3>> triples;
  triples.reserve(mesh.faces.size());
  std::vector<char> referenced(mesh.vertices.size(), 0);
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    const Eigen::Vector3i& face = mesh.faces[f];
    std::array<int, 3> triple = {face[0], face[1], face[2]};
    std::sort(triple.begin(), triple.end());
    triples.push_back(triple);
    for (int c = 0; c < 3; ++c) referenced[face[c]] = 1;
    report.degenerate_face_count += HasZeroArea(mesh, static_cast<int>(f));
  }
  std::sort(triples.begin(), triples.end());
  report.duplicate_face_count = CountRepeats(triples);
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    report.unreferenced_vertex_count += !referenced[v];
  }

  report.component_count = static_cast<int>(ConnectedComponents(mesh).size());

  const std::vector<EdgeUse> uses = SortedEdgeUses(mesh);
  for (size_t begin = 0; begin < uses.size();) {
    const size_t end = EdgeEnd(uses, begin);
    report.boundary_edge_count += end - begin == 1;
    report.nonmanifold_edge_count += end - begin > 2;
    report.inconsistent_edge_count +=
        end - begin == 2 && uses[begin].forward == uses[begin + 1].forward;
    begin = end;
  }
  return report;
}

int DropDegenerateFaces(TriangleMesh* mesh) {
  std::vector<int> degenerate;
  for (size_t f = 0; f < mesh->faces.size(); ++f) {
    if (HasZeroArea(*mesh, static_cast<int>(f))) degenerate.push_back(static_cast<int>(f));
  }
  if (degenerate.empty()) return 0;
  std::vector<int> parent(mesh->vertices.size());
  std::iota(parent.begin(), parent.end(), 0);
  for (const int f : degenerate) {
    for (int c = 0; c < 3; ++c) {
      const int a = mesh->faces[f][c];
      const int b = mesh->faces[f][(c + 1) % 3];
      if (mesh->vertices[a] == mesh->vertices[b])
        parent[FindRoot(&parent, a)] = FindRoot(&parent, b);
    }
  }
  std::vector<Eigen::Vector3i> kept;
  kept.reserve(mesh->faces.size() - degenerate.size());
  size_t next = 0;
  for (size_t f = 0; f < mesh->faces.size(); ++f) {
    if (next < degenerate.size() && degenerate[next] == static_cast<int>(f)) {
      ++next;
      continue;
    }
    Eigen::Vector3i face = mesh->faces[f];
    for (int& v : face) v = FindRoot(&parent, v);
    kept.push_back(face);
  }
  mesh->faces = std::move(kept);
  return static_cast<int>(degenerate.size());
}

int OrientConsistently(TriangleMesh* mesh) {
  struct Neighbor {
    int face = -1;
    bool agrees = true;
  };
  const int face_count = static_cast<int>(mesh->faces.size());
  const std::vector<EdgeUse> uses = SortedEdgeUses(*mesh);
  std::vector<std::array<Neighbor, 3>> neighbors(face_count);  // per side; -1: no single one
  bool all_agree = true;
  for (size_t begin = 0; begin < uses.size();) {
    const size_t end = EdgeEnd(uses, begin);
    if (end - begin == 2) {
      const bool agrees = uses[begin].forward != uses[begin + 1].forward;
      all_agree = all_agree && agrees;
      neighbors[uses[begin].face][uses[begin].side] = {uses[begin + 1].face, agrees};
      neighbors[uses[begin + 1].face][uses[begin + 1].side] = {uses[begin].face, agrees};
    }
    begin = end;
  }
  if (all_agree) return 0;
  int flipped_count = 0;
  std::vector<signed char> flip(face_count, -1);  // relative to the component's first face
  std::vector<int> component;
  for (int seed = 0; seed < face_count; ++seed) {
    if (flip[seed] >= 0) continue;
    component.assign(1, seed);
    flip[seed] = 0;
    bool orientable = true;
    for (size_t next = 0; next < component.size(); ++next) {
      const int f = component[next];
      for (const Neighbor& neighbor : neighbors[f]) {
        if (neighbor.face < 0) continue;
        const auto wanted = static_cast<signed char>(neighbor.agrees ? flip[f] : 1 - flip[f]);
        if (flip[neighbor.face] < 0) {
          flip[neighbor.face] = wanted;
          component.push_back(neighbor.face);
        } else {
          orientable = orientable && flip[neighbor.face] == wanted;
        }
      }
    }
    if (!orientable) continue;
    size_t ones = 0;
    for (int f : component) ones += flip[f];
    const signed char minority = 2 * ones <= component.size() ? 1 : 0;
    for (int f : component) {
      if (flip[f] != minority) continue;
      std::swap(mesh->faces[f][1], mesh->faces[f][2]);
      ++flipped_count;
    }
  }
  return flipped_count;
}

std::string MeshReport::Brief() const {
  std::string text = std::to_string(vertex_count) + " vertices, " + std::to_string(face_count) +
                     " faces, " + std::to_string(component_count) + " components, " +
                     std::to_string(boundary_edge_count) + " boundary edges";
  const std::pair<int, const char*> remarks[] = {
      {polygon_count, "polygons split"},
      {degenerate_face_count, "degenerate faces"},
      {duplicate_face_count, "duplicate faces"},
      {welded_vertex_count, "vertices welded"},
      {duplicate_vertex_count, "duplicate vertices"},
      {unreferenced_vertex_count, "unreferenced vertices"},
      {nonmanifold_edge_count, "non-manifold edges"},
      {reoriented_face_count, "faces reoriented"},
      {inconsistent_edge_count, "inconsistently oriented edges"}};
  const char* separator = "; ";
  for (const auto& [count, what] : remarks) {
    if (count == 0) continue;
    text += separator + std::to_string(count) + " " + what;
    separator = ", ";
  }
  return text;
}

}  // namespace burin
