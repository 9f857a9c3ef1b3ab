#include "core/visibility/view_domain.h"

#include <limits>

#include "core/visibility/facet_pencil.h"

namespace burin {

void ViewDomain::ListPixels(const TriangleMesh& mesh, const Camera& camera,
                            const cv::Mat1i& facet_map) {
  width = camera.width;
  height = camera.height;
  std::vector<int> slot(mesh.faces.size(), -1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (facet_map(y, x) >= 0) slot[facet_map(y, x)] = 0;
    }
  }
  facet.clear();
  for (size_t f = 0; f < slot.size(); ++f) {
    if (slot[f] < 0) continue;
    slot[f] = static_cast<int>(facet.size());
    facet.push_back(static_cast<int>(f));
  }
  std::vector<Eigen::Matrix3d> pencils(facet.size());
  const ViewRays rays(camera);
  for (size_t k = 0; k < pencils.size(); ++k) {
    pencils[k] = MakeFacetPencil(mesh.vertices, mesh.faces[facet[k]], rays).coefficients;
  }
  // Counting sort of the pixels by facet corner keeps them in ascending order within each.
  constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();
  std::vector<uint32_t> corner_of(static_cast<size_t>(width) * height, kNone);
  start.assign(3 * facet.size() + 1, 0);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (facet_map(y, x) < 0) continue;
      const int k = slot[facet_map(y, x)];
      const Eigen::Vector3d u = pencils[k] * Eigen::Vector3d(x + 0.5, y + 0.5, 1);
      const int corner = u[0] >= u[1] ? (u[0] >= u[2] ? 0 : 2) : (u[1] >= u[2] ? 1 : 2);
      corner_of[static_cast<size_t>(y) * width + x] = static_cast<uint32_t>(3 * k + corner);
      ++start[3 * k + corner + 1];
    }
  }
  for (size_t c = 1; c < start.size(); ++c) start[c] += start[c - 1];
  pixel.resize(start.back());
  std::vector<uint32_t> next(start.begin(), start.end() - 1);
  for (size_t p = 0; p < corner_of.size(); ++p) {
    if (corner_of[p] != kNone) pixel[next[corner_of[p]]++] = static_cast<uint32_t>(p);
  }
}

}  // namespace burin
