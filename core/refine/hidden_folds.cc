#include "core/refine/hidden_folds.h"

#include <vector>

namespace burin {
namespace {

// Vertices to move: hidden ones in connected parts that touch a vertex which is not hidden.
std::vector<int> HiddenAndAnchored(const RoundContext& context) {
  const int count = static_cast<int>(context.seen.size());
  const auto hidden = [&context](int v) {
    return context.moves[v] != 0 && context.seen[v] == 0 && context.supported[v] == 0;
  };
  std::vector<char> open(count);  // hidden and not yet reached
  for (int v = 0; v < count; ++v) open[v] = static_cast<char>(hidden(v));
  std::vector<int> moved;
  std::vector<int> part;
  for (int seed = 0; seed < count; ++seed) {
    if (open[seed] == 0) continue;
    part.assign(1, seed);
    open[seed] = 0;
    bool anchored = false;
    for (size_t k = 0; k < part.size(); ++k) {
      for (const int* n = context.neighbors.Begin(part[k]); n != context.neighbors.End(part[k]);
           ++n) {
        anchored |= !hidden(*n);
        if (open[*n] == 0) continue;
        open[*n] = 0;
        part.push_back(*n);
      }
    }
    if (anchored) moved.insert(moved.end(), part.begin(), part.end());
  }
  return moved;
}

}  // namespace

int RelaxHiddenFolds(const RoundContext& context, int sweeps, TriangleMesh* mesh) {
  const std::vector<int> moved = HiddenAndAnchored(context);
  std::vector<Eigen::Vector3d> next(moved.size());
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    for (size_t k = 0; k < moved.size(); ++k) {
      const int v = moved[k];
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      int count = 0;
      for (const int* n = context.neighbors.Begin(v); n != context.neighbors.End(v); ++n) {
        if (context.boundary[v] != 0 && context.boundary[*n] == 0) continue;
        sum += mesh->vertices[*n];
        ++count;
      }
      next[k] = count > 0 ? (sum / count).eval() : mesh->vertices[v];
    }
    for (size_t k = 0; k < moved.size(); ++k) mesh->vertices[moved[k]] = next[k];
  }
  return static_cast<int>(moved.size());
}

}  // namespace burin
