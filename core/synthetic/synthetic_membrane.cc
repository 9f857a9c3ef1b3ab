// membrane: the start has surface where there is free space, right in front of a camera.
#include <cmath>

#include "core/synthetic/synthetic_layout.h"
#include "core/synthetic/synthetic_rig.h"

namespace burin {
namespace {

constexpr double kHiddenShare = 1.0 / 3;  // of the view, from the left
constexpr double kDepthShare = 0.1;       // of the camera's distance from the scene
constexpr double kOverhang = 0.06;        // beyond the image, in image sizes
constexpr int kColumns = 12;
constexpr int kRows = 16;

// An open sheet, wavy in depth, that faces the camera.
void AppendMembrane(const Camera& camera, TriangleMesh* mesh) {
  const int first = static_cast<int>(mesh->vertices.size());
  const double depth = kDepthShare * camera.Center().norm();
  for (int r = 0; r <= kRows; ++r) {
    for (int c = 0; c <= kColumns; ++c) {
      const double u = static_cast<double>(c) / kColumns;
      const double v = static_cast<double>(r) / kRows;
      const double x = (-kOverhang + (kHiddenShare + kOverhang) * u) * camera.width;
      const double y = (-kOverhang + (1 + 2 * kOverhang) * v) * camera.height;
      const double waves = 1 + 0.08 * std::sin(5 * u + 4 * v) - 0.1 * u;
      mesh->vertices.emplace_back(camera.Center() + depth * waves * camera.Ray(x, y));
    }
  }
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kColumns; ++c) {
      // Image rows go down: counter-clockwise seen from the camera is left, down, right, up.
      const int corner = first + r * (kColumns + 1) + c;
      const int below = corner + kColumns + 1;
      mesh->faces.emplace_back(corner, below, below + 1);
      mesh->faces.emplace_back(corner, below + 1, corner + 1);
    }
  }
}

}  // namespace

SyntheticLayout MembraneLayout(const SyntheticOptions& options) {
  SyntheticLayout layout = ReliefLayout(options);
  AppendMembrane(layout.cameras[layout.cameras.size() / 2], &layout.init);
  return layout;
}

}  // namespace burin
