#include "core/refine/support.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/refine/thin_parts.h"
#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kVertexGrain = 4096;

// The share of supported vertices around each is a diffusion of this many sweeps, a reach of some four rings.
constexpr int kSweeps = 20;
// F1 of fountain-P11 and `occluders` is the same to noise from .3 to .5, and for 5 to 20 sweeps.
constexpr float kEnough = 0.4F;
// Of the level; the width of a window of the usual size. With 3, thin-stem is the same and rods gain less.
constexpr double kThinPx = 5;

// The share of supported vertices among those seen around each vertex; 0 where it is not seen.
std::vector<float> SupportAround(const RoundContext& context) {
  std::vector<float> share(context.supported.begin(), context.supported.end());
  std::vector<float> next(share.size());
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    ParallelFor(static_cast<int>(share.size()), kVertexGrain, [&](int begin, int end) {
      for (int v = begin; v < end; ++v) {
        next[v] = 0;
        if (context.seen[v] == 0) continue;
        float sum = share[v];
        int count = 1;
        for (const int* n = context.neighbors.Begin(v); n != context.neighbors.End(v); ++n) {
          if (context.seen[*n] == 0) continue;
          sum += share[*n];
          ++count;
        }
        next[v] = sum / static_cast<float>(count);
      }
    });
    std::swap(share, next);
  }
  return share;
}

}  // namespace

int FindSupport(const TermRounds& terms, const MeshOrder& order, HiddenVertices hidden,
                bool cameras_move, std::vector<char>* was_supported, RoundContext* context) {
  context->supported.assign(context->seen.size(), 0);
  for (const auto& [term, round] : terms) {
    round->MarkSupported(context->mesh->vertices, &context->supported);
  }
  const std::vector<float> around = SupportAround(*context);
  std::vector<char> outlined(context->seen.size(), 0);
  std::vector<char> free(context->seen.size(), 0);
  for (const auto& [term, round] : terms) round->MarkOutlined(&outlined, &free);
  for (size_t v = 0; v < outlined.size(); ++v) {
    if (outlined[v] == 0) continue;
    if (context->supported[v] == 0) free[v] = 1;
    context->supported[v] = 1;
  }
  context->moves = context->supported;
  for (size_t v = 0; v < order.vertex.size(); ++v) {
    char& was_seen = (*was_supported)[order.vertex[v]];
    const bool seen = context->seen[v] != 0;
    if (seen) was_seen = 1;
    const bool is_hidden = was_seen != 0 && !seen;
    if (around[v] > kEnough || (is_hidden && hidden == HiddenVertices::kRelax)) {
      context->moves[v] = 1;
    }
  }
  context->keeps_shape =
      ThinVertices(*context->mesh, context->normals, kThinPx * std::ldexp(1.0, context->level));
  for (size_t v = 0; v < context->moves.size(); ++v) {
    if (context->moves[v] == 0 || free[v] != 0) context->keeps_shape[v] = 1;
  }
  if (!cameras_move) context->free = std::move(free);
  return static_cast<int>(std::count(context->supported.begin(), context->supported.end(), 1));
}

}  // namespace burin
