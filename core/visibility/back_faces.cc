#include "core/visibility/back_faces.h"

#include "core/visibility/facet_map.h"
#include "core/visibility/facet_pencil.h"

namespace burin {

BackFaces CountBackFaces(const TriangleMesh& mesh, const std::vector<Camera>& cameras) {
  BackFaces count;
  for (const Camera& camera : cameras) {
    const std::vector<uint8_t> facing = FacingFacets(mesh, camera.Center());
    for (const int facet : FacetMap(mesh, camera)) {
      if (facet < 0) continue;
      ++count.pixels;
      count.back += facing[facet] == 0 ? 1 : 0;
    }
  }
  return count;
}

}  // namespace burin
