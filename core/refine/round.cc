#include "core/refine/round.h"

#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kVertexGrain = 4096;

// Vertices of the facets that have a pixel in some Omega_ij.
std::vector<char> SeenVertices(const std::vector<ViewDomain>& domains, const TriangleMesh& mesh) {
  const int count = static_cast<int>(mesh.vertices.size());
  std::vector<std::vector<char>> by_view(domains.size());
  ParallelFor(static_cast<int>(domains.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const ViewDomain& domain = domains[i];
      by_view[i].assign(count, 0);
      for (size_t k = 0; k < domain.facet.size(); ++k) {
        for (const ImagePixel pixel : domain.PixelsOf(k)) {
          if (!domain.second_visible.Any(pixel.index)) continue;
          for (int c = 0; c < 3; ++c) by_view[i][mesh.faces[domain.facet[k]][c]] = 1;
          break;
        }
      }
    }
  });
  std::vector<char> seen(count, 0);
  ParallelFor(count, kVertexGrain, [&](int begin, int end) {
    for (const std::vector<char>& view : by_view) {
      for (int v = begin; v < end; ++v) seen[v] = static_cast<char>(seen[v] | view[v]);
    }
  });
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
  return context;
}

}  // namespace burin
