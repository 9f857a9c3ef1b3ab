// Which side the cameras see of each connected part of a mesh. A facet seen from behind belongs to no pair's region
// (core/visibility/visibility.h), so a part that is inside out takes no part in a refinement, and hides what is
// behind it.
#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/camera.h"

namespace burin {

struct PartSides {
  std::vector<int> faces;  // a connected component of the mesh (ConnectedComponents)
  double area = 0;
  // Pixels of small images of all cameras whose ray meets the part first, from the front and from behind.
  int64_t front = 0;
  int64_t behind = 0;

  // Hardly any pixel sees its front, and enough see its back to tell.
  bool InsideOut() const;
};

std::vector<PartSides> LookAtParts(const std::vector<Camera>& cameras, const TriangleMesh& mesh);

// Reverses the facets of the parts that are inside out, and swaps what is seen of their sides; returns the indices of
// these parts. Which facet a ray meets first stays as it is.
std::vector<int> TurnPartsInsideOut(std::vector<PartSides>* parts, TriangleMesh* mesh);

}  // namespace burin
