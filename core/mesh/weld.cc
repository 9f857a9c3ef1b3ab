#include "core/mesh/weld.h"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

#include "core/support/union_find.h"

namespace burin {
namespace {

// Of every vertex, the first one at its position.
std::vector<int> FirstAtPosition(const TriangleMesh& mesh) {
  std::vector<int> order(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&mesh](int v) {
    const Eigen::Vector3d& p = mesh.vertices[v];
    return std::array<double, 3>{p.x(), p.y(), p.z()};
  };
  std::sort(order.begin(), order.end(), [&key](int a, int b) {
    const auto at_a = key(a);
    const auto at_b = key(b);
    return at_a != at_b ? at_a < at_b : a < b;
  });
  std::vector<int> first(order.size());
  for (size_t k = 0; k < order.size(); ++k) {
    const bool same = k > 0 && key(order[k]) == key(order[k - 1]);
    first[order[k]] = same ? first[order[k - 1]] : order[k];
  }
  return first;
}

// A side of a face, between the positions low < high.
struct Side {
  int low, high;    // of FirstAtPosition
  int at_low = -1;  // the vertices there
  int at_high = -1;
};

// All sides, those between the same positions next to each other.
std::vector<Side> SortedSides(const TriangleMesh& mesh, const std::vector<int>& first) {
  std::vector<Side> sides;
  sides.reserve(3 * mesh.faces.size());
  for (const Eigen::Vector3i& face : mesh.faces) {
    for (int c = 0; c < 3; ++c) {
      int a = face[c];
      int b = face[(c + 1) % 3];
      if (first[a] > first[b]) std::swap(a, b);
      sides.push_back({first[a], first[b], a, b});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::pair(a.low, a.high) < std::pair(b.low, b.high);
  });
  return sides;
}

size_t SidesEnd(const std::vector<Side>& sides, size_t begin) {
  size_t end = begin + 1;
  while (end < sides.size() && sides[end].low == sides[begin].low &&
         sides[end].high == sides[begin].high) {
    ++end;
  }
  return end;
}

// Joins the ends of matching borders but for those at `kept_apart` positions.
std::vector<int> Joined(const std::vector<Side>& sides, const std::vector<char>& kept_apart) {
  std::vector<int> parent(kept_apart.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto join = [&parent, &kept_apart](int position, int a, int b) {
    if (kept_apart[position] != 0) return;
    a = FindRoot(&parent, a);
    b = FindRoot(&parent, b);
    parent[std::max(a, b)] = std::min(a, b);
  };
  for (size_t begin = 0; begin < sides.size();) {
    const size_t end = SidesEnd(sides, begin);
    if (end - begin == 2 && sides[begin].low != sides[begin].high) {
      join(sides[begin].low, sides[begin].at_low, sides[begin + 1].at_low);
      join(sides[begin].high, sides[begin].at_high, sides[begin + 1].at_high);
    }
    begin = end;
  }
  for (size_t v = 0; v < parent.size(); ++v) parent[v] = FindRoot(&parent, static_cast<int>(v));
  return parent;
}

// Marks the positions between which joining has made edges of more than two faces; whether there are any.
bool MarkCrowded(const std::vector<Side>& sides, const std::vector<int>& joined,
                 std::vector<char>* kept_apart) {
  bool any = false;
  for (size_t begin = 0; begin < sides.size();) {
    const size_t end = SidesEnd(sides, begin);
    if (end - begin > 2) {
      std::map<std::pair<int, int>, std::pair<int, std::set<std::pair<int, int>>>> edges;
      for (size_t k = begin; k < end; ++k) {
        auto& [uses, given] = edges[{joined[sides[k].at_low], joined[sides[k].at_high]}];
        ++uses;
        given.insert({sides[k].at_low, sides[k].at_high});
      }
      for (const auto& [ends, edge] : edges) {
        if (edge.first <= 2 || edge.second.size() == 1) continue;  // as few, or as it was
        (*kept_apart)[sides[begin].low] = (*kept_apart)[sides[begin].high] = 1;
        any = true;
      }
    }
    begin = end;
  }
  return any;
}

}  // namespace

int DropDuplicateFaces(TriangleMesh* mesh) {
  const std::vector<int> first = FirstAtPosition(*mesh);
  std::set<std::array<int, 3>> vertices;   // ascending
  std::set<std::array<int, 3>> positions;  // in the face's direction, from the smallest on
  std::vector<Eigen::Vector3i> kept;
  kept.reserve(mesh->faces.size());
  for (const Eigen::Vector3i& face : mesh->faces) {
    std::array<int, 3> sorted = {face[0], face[1], face[2]};
    std::sort(sorted.begin(), sorted.end());
    std::array<int, 3> turned = {first[face[0]], first[face[1]], first[face[2]]};
    std::rotate(turned.begin(), std::min_element(turned.begin(), turned.end()), turned.end());
    const bool new_vertices = vertices.insert(sorted).second;
    if (positions.insert(turned).second && new_vertices) kept.push_back(face);
  }
  const auto dropped = static_cast<int>(mesh->faces.size() - kept.size());
  mesh->faces = std::move(kept);
  return dropped;
}

int WeldSeams(TriangleMesh* mesh) {
  const std::vector<int> first = FirstAtPosition(*mesh);
  const std::vector<Side> sides = SortedSides(*mesh, first);
  std::vector<char> kept_apart(first.size(), 0);
  std::vector<int> joined = Joined(sides, kept_apart);
  while (MarkCrowded(sides, joined, &kept_apart)) joined = Joined(sides, kept_apart);
  std::vector<int> index(joined.size(), -1);
  std::vector<Eigen::Vector3d> vertices;
  for (size_t v = 0; v < joined.size(); ++v) {
    if (joined[v] != static_cast<int>(v)) continue;
    index[v] = static_cast<int>(vertices.size());
    vertices.push_back(mesh->vertices[v]);
  }
  const auto welded = static_cast<int>(mesh->vertices.size() - vertices.size());
  if (welded == 0) return 0;
  mesh->vertices = std::move(vertices);
  for (Eigen::Vector3i& face : mesh->faces) {
    for (int& v : face) v = index[joined[v]];
  }
  return welded;
}

}  // namespace burin
