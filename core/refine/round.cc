#include "core/refine/round.h"

#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kFacetGrain = 512;

// Vertices of the facets that have a pixel in some Omega_ij.
std::vector<char> SeenVertices(const std::vector<ViewDomain>& domains, const TriangleMesh& mesh) {
  std::vector<char> facet_seen(mesh.faces.size(), 0);
  for (const ViewDomain& domain : domains) {
    ParallelFor(static_cast<int>(domain.facet.size()), kFacetGrain, [&](int begin, int end) {
      for (int k = begin; k < end; ++k) {
        char& seen = facet_seen[domain.facet[k]];
        if (seen != 0) continue;
        for (const ImagePixel pixel : domain.PixelsOf(k)) {
          if (domain.second_visible.Any(pixel.index)) seen = 1;
          if (seen != 0) break;
        }
      }
    });
  }
  std::vector<char> seen(mesh.vertices.size(), 0);
  for (size_t f = 0; f < facet_seen.size(); ++f) {
    if (facet_seen[f] == 0) continue;
    for (const int v : mesh.faces[f]) seen[v] = 1;
  }
  return seen;
}

}  // namespace

std::vector<CameraPair> TakingPart(const std::vector<CameraPair>& pairs,
                                   const std::vector<LevelView>& views) {
  std::vector<CameraPair> kept;
  for (const CameraPair& pair : pairs) {
    if (views[pair.reference].at.takes_part && views[pair.second].at.takes_part) {
      kept.push_back(pair);
    }
  }
  return kept;
}

RoundContext FreezeRound(const std::vector<LevelView>& views, const std::vector<CameraPair>& pairs,
                         const TriangleMesh& mesh, Motion motion, double border_px,
                         std::vector<ViewDomain>* domains,
                         const std::vector<CameraPair>& held_back_pairs,
                         std::vector<ViewPartners>* held_back) {
  std::vector<Camera> cameras;
  cameras.reserve(views.size());
  std::vector<cv::Mat> masks;
  for (const LevelView& view : views) {
    cameras.push_back(view.camera);
    masks.push_back(view.mask);
  }
  *domains = RayCaster(mesh).Cast(cameras, TakingPart(pairs, views), border_px, masks,
                                  TakingPart(held_back_pairs, views), held_back);

  RoundContext context;
  context.views = &views;
  context.domains = domains;
  context.held_back = held_back;
  context.mesh = &mesh;
  context.faces = VertexFaces(mesh);
  context.neighbors = VertexNeighbors(mesh, context.faces);
  context.boundary = BoundaryVertices(mesh, context.faces);
  context.normals = VertexNormals(mesh, context.faces);
  context.motion = motion;
  context.seen = SeenVertices(*domains, mesh);
  context.supported = context.seen;
  context.moves = context.seen;
  context.keeps_shape.assign(context.seen.size(), 0);
  context.free.assign(context.seen.size(), 0);
  return context;
}

}  // namespace burin
