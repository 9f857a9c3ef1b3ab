#include "core/visibility/back_faces.h"

#include "core/visibility/facet_rays.h"

namespace burin {

BackFaces CountBackFaces(const TriangleMesh& mesh, const std::vector<Camera>& cameras) {
  BackFaces count;
  const FacetRays rays(mesh);
  for (const Camera& camera : cameras) {
    const std::vector<uint8_t> facing = rays.Facing(camera.Center());
    for (const int facet : rays.FacetMap(camera)) {
      if (facet < 0) continue;
      ++count.pixels;
      count.back += facing[facet] == 0 ? 1 : 0;
    }
  }
  return count;
}

}  // namespace burin
