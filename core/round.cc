#include "core/round.h"

namespace burin {

RoundContext FreezeRound(const std::vector<LevelView>& views, const std::vector<CameraPair>& pairs,
                         const TriangleMesh& mesh, Motion motion, double border_px,
                         std::vector<ViewDomain>* domains) {
  std::vector<Camera> cameras;
  cameras.reserve(views.size());
  for (const LevelView& view : views) cameras.push_back(view.camera);
  *domains = RayCaster(mesh).Cast(cameras, pairs, border_px);

  RoundContext context;
  context.views = &views;
  context.domains = domains;
  context.mesh = &mesh;
  context.neighbors = VertexNeighbors(mesh);
  context.faces = VertexFaces(mesh);
  context.boundary = BoundaryVertices(mesh);
  context.normals = VertexNormals(mesh);
  context.motion = motion;
  context.supported.assign(mesh.vertices.size(), 0);
  for (const ViewDomain& domain : *domains) {
    for (size_t k = 0; k < domain.facet.size(); ++k) {
      const Eigen::Vector3i& face = mesh.faces[domain.facet[k]];
      if (context.supported[face[0]] && context.supported[face[1]] && context.supported[face[2]]) {
        continue;
      }
      for (uint32_t n = domain.start[3 * k]; n < domain.start[3 * k + 3]; ++n) {
        uint8_t any = 0;
        for (const auto& plane : domain.second_visible) any |= plane[domain.pixel[n]];
        if (any == 0) continue;
        for (int c = 0; c < 3; ++c) context.supported[face[c]] = 1;
        break;
      }
    }
  }
  context.was_supported = context.supported;
  return context;
}

}  // namespace burin
