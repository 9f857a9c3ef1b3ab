#include "core/visibility/back_faces.h"

#include "core/visibility/facet_map.h"
#include "core/visibility/facet_pencil.h"

namespace burin {

BackFaces CountBackFaces(const TriangleMesh& mesh, const std::vector<Camera>& cameras) {
  BackFaces count;
  for (const Camera& camera : cameras) {
    const Eigen::Vector3d center = camera.Center();
    for (const int facet : FacetMap(mesh, camera)) {
      if (facet < 0) continue;
      ++count.pixels;
      count.back += FacesCenter(mesh.vertices, mesh.faces[facet], center) ? 0 : 1;
    }
  }
  return count;
}

}  // namespace burin
