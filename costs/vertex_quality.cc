#include "costs/vertex_quality.h"

#include <cmath>
#include <cstdint>
#include <limits>

#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kFacetGrain = 512;
constexpr int kVertexGrain = 1024;
constexpr float kUndefined = std::numeric_limits<float>::quiet_NaN();

// Adds, per vertex, the pairs of one view that see one of its facets.
void CountPairs(const ViewDomain& domain, const RoundContext& context, std::vector<float>* pairs) {
  PartnerBits seen(domain.seconds.size(), context.mesh->faces.size());  // by facet
  ParallelFor(static_cast<int>(domain.facet.size()), kFacetGrain, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      for (const ImagePixel pixel : domain.PixelsOf(k)) {
        seen.Unite(domain.facet[k], domain.second_visible, pixel.index, 1);
      }
    }
  });
  ParallelFor(static_cast<int>(pairs->size()), kVertexGrain, [&](int begin, int end) {
    PartnerBits any(domain.seconds.size(), 1);
    for (int v = begin; v < end; ++v) {
      any.ClearAll(0);
      for (const int* f = context.faces.Begin(v); f != context.faces.End(v); ++f) {
        any.Unite(0, seen, *f, 1);
      }
      (*pairs)[v] += static_cast<float>(any.Count(0));
    }
  });
}

}  // namespace

VertexQuality MeasureVertexQuality(const TriangleMesh& mesh, PhotometricRound* round) {
  const RoundContext& context = round->context();
  const std::vector<FacetScore> scores =
      round->FacetScores(mesh.vertices, PhotometricRound::Windows::kUsed, /*derivatives=*/true);
  const std::vector<Eigen::Vector3d> normals = VertexNormals(mesh, context.faces);
  const CornerSumsList& sums = round->corner_sums();
  const std::vector<Eigen::Vector3d>& facet_normals = round->facet_normals();

  const auto count = static_cast<int>(mesh.vertices.size());
  VertexQuality quality;
  quality.pairs.assign(count, 0);
  for (const ViewDomain& domain : *context.domains) CountPairs(domain, context, &quality.pairs);
  quality.zncc.assign(count, kUndefined);
  quality.windows.assign(count, 0);
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
        const double along = facet_normals[*f].dot(normals[v]);
        for (int k = 0; k < 3; ++k) {
          if (mesh.faces[*f][k] != v) continue;
          for (int corner = 0; corner < 3; ++corner) {
            curvature +=
                sums[3 * static_cast<size_t>(*f) + corner].curvature[kDiagonal[k]] * along * along;
          }
        }
      }
      quality.windows[v] = static_cast<float>(around.weight);
      if (around.weight <= 0) continue;
      const double error = around.cost / around.weight;
      quality.zncc[v] = static_cast<float>(1 - error);
      if (curvature > 0) quality.sd[v] = static_cast<float>(std::sqrt(2 * error / curvature));
    }
  });
  return quality;
}

}  // namespace burin
