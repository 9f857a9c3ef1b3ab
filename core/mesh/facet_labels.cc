#include "core/mesh/facet_labels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kFacetGrain = 4096;
constexpr int kDiffusionSteps = 4;
constexpr char kCut = 1;
constexpr char kKept = 0;

void Diffuse(const Adjacency& neighbors, std::vector<char>* labels) {
  std::vector<float> share(labels->begin(), labels->end());
  DiffuseOverFacets(neighbors, kDiffusionSteps, &share);
  for (size_t f = 0; f < share.size(); ++f) (*labels)[f] = share[f] > 0.5F ? kCut : kKept;
}

// Gives patches of `label` the other one where they are small and border on it.
void DropSmallPatches(const Adjacency& neighbors, const std::vector<double>& area_px, char label,
                      std::vector<char>* labels) {
  std::vector<char> chosen(labels->size());
  for (size_t f = 0; f < chosen.size(); ++f) chosen[f] = (*labels)[f] == label ? 1 : 0;
  for (const std::vector<int>& patch : FacetPatches(neighbors, chosen)) {
    double area = 0;
    bool borders = false;
    for (const int f : patch) {
      area += area_px[f];
      borders |=
          std::any_of(neighbors.Begin(f), neighbors.End(f), [&](int n) { return chosen[n] == 0; });
    }
    if (!borders || area >= kLeastPatchPx) continue;
    for (const int f : patch) (*labels)[f] = label == kCut ? kKept : kCut;
  }
}

int NeighborsOf(const Adjacency& neighbors, const std::vector<char>& labels, int f, char label) {
  return static_cast<int>(std::count_if(neighbors.Begin(f), neighbors.End(f),
                                        [&](int n) { return labels[n] == label; }));
}

// Facets of `label` with two or more neighbours of the other one get it, all at once.
void FillTeeth(const Adjacency& neighbors, char label, std::vector<char>* labels) {
  std::vector<int> teeth;
  for (size_t f = 0; f < labels->size(); ++f) {
    const char other = label == kCut ? kKept : kCut;
    const auto at = static_cast<int>(f);
    if ((*labels)[f] == label && NeighborsOf(neighbors, *labels, at, other) >= 2) {
      teeth.push_back(at);
    }
  }
  for (const int f : teeth) (*labels)[f] = label == kCut ? kKept : kCut;
}

// How many runs of facets that share edges the facets of `chosen` at a vertex are.
int Fans(const TriangleMesh& mesh, const std::vector<int>& chosen) {
  std::vector<int> run(chosen.size());
  int fans = 0;
  std::vector<char> reached(chosen.size(), 0);
  for (size_t first = 0; first < chosen.size(); ++first) {
    if (reached[first] != 0) continue;
    ++fans;
    std::vector<size_t> queue = {first};
    reached[first] = 1;
    for (size_t k = 0; k < queue.size(); ++k) {
      for (size_t other = 0; other < chosen.size(); ++other) {
        if (reached[other] != 0 ||
            CommonVertices(mesh.faces[chosen[queue[k]]], mesh.faces[chosen[other]]) < 2) {
          continue;
        }
        reached[other] = 1;
        queue.push_back(other);
      }
    }
  }
  return fans;
}

// Keeps all facets at vertices where those that are left would touch at the vertex only and the whole mesh does not.
void KeepAtPinches(const TriangleMesh& mesh, const Adjacency& vertex_faces,
                   std::vector<char>* labels) {
  std::vector<int> queue;
  for (size_t v = 0; v < mesh.vertices.size(); ++v) queue.push_back(static_cast<int>(v));
  for (size_t k = 0; k < queue.size(); ++k) {
    const int v = queue[k];
    const std::vector<int> all(vertex_faces.Begin(v), vertex_faces.End(v));
    std::vector<int> kept;
    for (const int f : all) {
      if ((*labels)[f] == kKept) kept.push_back(f);
    }
    if (kept.size() < 2 || kept.size() == all.size()) continue;
    if (Fans(mesh, kept) <= Fans(mesh, all)) continue;
    for (const int f : all) {
      if (std::exchange((*labels)[f], kKept) == kKept) continue;
      for (const int other : mesh.faces[f]) queue.push_back(other);
    }
  }
}

}  // namespace

Adjacency FacetNeighbors(const TriangleMesh& mesh) {
  struct Side {
    int low;
    int high;
    int facet;
    bool operator<(const Side& other) const {
      return std::tie(low, high, facet) < std::tie(other.low, other.high, other.facet);
    }
  };
  std::vector<Side> sides;
  sides.reserve(3 * mesh.faces.size());
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    for (int c = 0; c < 3; ++c) {
      const int a = mesh.faces[f][c];
      const int b = mesh.faces[f][(c + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), static_cast<int>(f)});
    }
  }
  std::sort(sides.begin(), sides.end());
  std::vector<std::array<int, 2>> links;
  for (size_t begin = 0; begin < sides.size();) {
    size_t end = begin + 1;
    while (end < sides.size() && sides[end].low == sides[begin].low &&
           sides[end].high == sides[begin].high) {
      ++end;
    }
    for (size_t a = begin; a < end; ++a) {
      for (size_t b = begin; b < end; ++b) {
        if (sides[a].facet != sides[b].facet) links.push_back({sides[a].facet, sides[b].facet});
      }
    }
    begin = end;
  }
  std::sort(links.begin(), links.end());
  links.erase(std::unique(links.begin(), links.end()), links.end());
  Adjacency neighbors;
  neighbors.start.assign(mesh.faces.size() + 1, 0);
  for (const auto& [from, to] : links) {
    ++neighbors.start[from + 1];
    neighbors.index.push_back(to);
  }
  for (size_t f = 0; f < mesh.faces.size(); ++f) neighbors.start[f + 1] += neighbors.start[f];
  return neighbors;
}

void DiffuseOverFacets(const Adjacency& neighbors, int steps, std::vector<float>* values) {
  std::vector<float> next(values->size());
  for (int step = 0; step < steps; ++step) {
    ParallelFor(static_cast<int>(next.size()), kFacetGrain, [&](int begin, int end) {
      for (int f = begin; f < end; ++f) {
        float sum = 0;
        float count = 0;
        const auto add = [&](int g) {
          if (!std::isfinite((*values)[g])) return;
          sum += (*values)[g];
          ++count;
        };
        add(f);
        if (count > 0) std::for_each(neighbors.Begin(f), neighbors.End(f), add);
        next[f] = sum / count;  // not a number where it was none
      }
    });
    std::swap(*values, next);
  }
}

std::vector<std::vector<int>> FacetPatches(const Adjacency& neighbors,
                                           const std::vector<char>& chosen) {
  std::vector<std::vector<int>> patches;
  std::vector<char> done(chosen.size(), 0);
  for (size_t f = 0; f < chosen.size(); ++f) {
    if (done[f] != 0 || chosen[f] == 0) continue;
    std::vector<int> patch = {static_cast<int>(f)};
    done[f] = 1;
    for (size_t k = 0; k < patch.size(); ++k) {
      for (const int* n = neighbors.Begin(patch[k]); n != neighbors.End(patch[k]); ++n) {
        if (chosen[*n] != 0 && std::exchange(done[*n], 1) == 0) patch.push_back(*n);
      }
    }
    std::sort(patch.begin(), patch.end());
    patches.push_back(std::move(patch));
  }
  return patches;
}

std::vector<char> SmoothedLabels(const TriangleMesh& mesh, const Adjacency& neighbors,
                                 const std::vector<double>& area_px, std::vector<char> cut) {
  Diffuse(neighbors, &cut);
  FillTeeth(neighbors, kCut, &cut);
  FillTeeth(neighbors, kKept, &cut);
  DropSmallPatches(neighbors, area_px, kCut, &cut);
  DropSmallPatches(neighbors, area_px, kKept, &cut);
  KeepAtPinches(mesh, VertexFaces(mesh), &cut);
  DropSmallPatches(neighbors, area_px, kCut, &cut);  // that pinches have left
  return cut;
}

}  // namespace burin
