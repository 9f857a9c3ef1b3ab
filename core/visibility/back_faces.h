// How much of what the views see of a mesh is seen from behind: where one sheet came through another, or holes
// show the inside.
#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/camera.h"

namespace burin {

struct BackFaces {
  int64_t pixels = 0;  // that see the mesh, over all views
  int64_t back = 0;    // of those: the facet that they see first is turned away
  double Share() const {
    return pixels > 0 ? static_cast<double>(back) / static_cast<double>(pixels) : 0;
  }
};

// One ray through the centre of every pixel of `cameras`.
BackFaces CountBackFaces(const TriangleMesh& mesh, const std::vector<Camera>& cameras);

}  // namespace burin
