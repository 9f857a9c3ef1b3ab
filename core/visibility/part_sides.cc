#include "core/visibility/part_sides.h"

#include <algorithm>
#include <opencv2/core.hpp>
#include <utility>

#include "core/visibility/facet_map.h"

namespace burin {
namespace {

constexpr double kColumns = 160;     // of the images that are cast
constexpr double kFromBehind = 0.9;  // share of a part's pixels
// Fewer pixels may all lie on an edge that is seen past something else.
constexpr int64_t kEnoughPixels = 16;

Camera Small(const Camera& camera) {
  const double shrink = std::max(1.0, camera.width / kColumns);
  return camera.Resized(std::max(1, static_cast<int>(camera.width / shrink)),
                        std::max(1, static_cast<int>(camera.height / shrink)));
}

}  // namespace

bool PartSides::InsideOut() const {
  return behind >= kEnoughPixels &&
         static_cast<double>(behind) > kFromBehind * static_cast<double>(front + behind);
}

std::vector<PartSides> LookAtParts(const std::vector<Camera>& cameras, const TriangleMesh& mesh) {
  std::vector<PartSides> parts;
  std::vector<int> part_of(mesh.faces.size());
  for (std::vector<int>& faces : ConnectedComponents(mesh)) {
    PartSides part;
    for (const int f : faces) {
      part_of[f] = static_cast<int>(parts.size());
      part.area += FaceAreaNormal(mesh, f).norm() / 2;
    }
    part.faces = std::move(faces);
    parts.push_back(std::move(part));
  }
  for (const Camera& camera : cameras) {
    const Eigen::Vector3d center = camera.Center();
    for (const int facet : FacetMap(mesh, Small(camera))) {
      if (facet < 0) continue;
      const Eigen::Vector3d to_camera = center - mesh.vertices[mesh.faces[facet][0]];
      PartSides& part = parts[part_of[facet]];
      ++(FaceAreaNormal(mesh, facet).dot(to_camera) > 0 ? part.front : part.behind);
    }
  }
  return parts;
}

std::vector<int> TurnPartsInsideOut(std::vector<PartSides>* parts, TriangleMesh* mesh) {
  std::vector<int> turned;
  for (size_t p = 0; p < parts->size(); ++p) {
    PartSides& part = (*parts)[p];
    if (!part.InsideOut()) continue;
    for (const int f : part.faces) std::swap(mesh->faces[f][1], mesh->faces[f][2]);
    std::swap(part.front, part.behind);
    turned.push_back(static_cast<int>(p));
  }
  return turned;
}

}  // namespace burin
