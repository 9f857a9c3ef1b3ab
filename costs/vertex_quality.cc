#include "costs/vertex_quality.h"

#include <cmath>
#include <cstdint>
#include <limits>

#include "core/parallel.h"
#include "core/round.h"

namespace burin {
namespace {

constexpr int kVertexGrain = 1024;
constexpr float kUndefined = std::numeric_limits<float>::quiet_NaN();

// Adds, per vertex, the pairs of one view that see one of its facets.
void CountPairs(const ViewDomain& domain, const TriangleMesh& mesh, std::vector<float>* pairs) {
  std::vector<uint8_t> seen(mesh.vertices.size());
  for (const std::vector<uint8_t>& plane : domain.second_visible) {
    std::fill(seen.begin(), seen.end(), 0);
    for (size_t k = 0; k < domain.facet.size(); ++k) {
      uint8_t any = 0;
      for (uint32_t n = domain.start[3 * k]; n < domain.start[3 * k + 3]; ++n) {
        any |= plane[domain.pixel[n]];
      }
      for (int c = 0; c < 3; ++c) seen[mesh.faces[domain.facet[k]][c]] |= any;
    }
    for (size_t v = 0; v < seen.size(); ++v) {
      (*pairs)[v] += static_cast<float>(__builtin_popcount(seen[v]));
    }
  }
}

}  // namespace

VertexQuality MeasureVertexQuality(const std::vector<LevelView>& views,
                                   const std::vector<CameraPair>& pairs, const TriangleMesh& mesh,
                                   double border_px, PhotometricEnergy* photometric) {
  std::vector<ViewDomain> domains;
  const RoundContext context =
      FreezeRound(views, pairs, mesh, Motion::kNormal, border_px, &domains);
  photometric->BeginRound(context);
  const std::vector<FacetScore> scores = photometric->FacetScores(mesh.vertices, false);
  photometric->Evaluate(mesh.vertices, /*derivatives=*/true);
  const std::vector<CornerSums>& sums = photometric->corner_sums();
  const std::vector<Eigen::Vector3d>& facet_normals = photometric->facet_normals();

  const auto count = static_cast<int>(mesh.vertices.size());
  VertexQuality quality;
  quality.pairs.assign(count, 0);
  for (const ViewDomain& domain : domains) CountPairs(domain, mesh, &quality.pairs);
  quality.zncc.assign(count, kUndefined);
  quality.sd.assign(count, kUndefined);
  // Of the packed upper triangle of CornerSums::curvature.
  constexpr int kDiagonal[3] = {0, 3, 5};
  ParallelFor(count, kVertexGrain, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      FacetScore around;
      double curvature = 0;
      for (const int* f = context.faces.Begin(v); f != context.faces.End(v); ++f) {
        around.cost += scores[*f].cost;
        around.weight += scores[*f].weight;
        const double along = facet_normals[*f].dot(context.normals[v]);
        for (int k = 0; k < 3; ++k) {
          if (mesh.faces[*f][k] != v) continue;
          for (int corner = 0; corner < 3; ++corner) {
            curvature +=
                sums[3 * static_cast<size_t>(*f) + corner].curvature[kDiagonal[k]] * along * along;
          }
        }
      }
      if (around.weight <= 0) continue;
      const double error = around.cost / around.weight;
      quality.zncc[v] = static_cast<float>(1 - error);
      if (curvature > 0) quality.sd[v] = static_cast<float>(std::sqrt(2 * error / curvature));
    }
  });
  return quality;
}

}  // namespace burin
