#include "core/visibility/view_domain.h"

#include "core/visibility/facet_pencil.h"

namespace burin {

void ViewDomain::ListPixels(const TriangleMesh& mesh, const Camera& camera, const CornerMap& map,
                            std::vector<PixelDepth>* behind) {
  constexpr int kBehind = -1;
  width = camera.width;
  height = camera.height;
  std::vector<char> seen(mesh.faces.size(), 0);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int code = map.CodeAt(x, y);
      if (code >= 0) seen[FacetCorner::Of(code).facet] = 1;
    }
  }
  const Eigen::Vector3d center = camera.Center();
  std::vector<int> slot(mesh.faces.size(), kBehind);
  facet.clear();
  for (size_t f = 0; f < seen.size(); ++f) {
    if (seen[f] == 0 || !FacesCenter(mesh.vertices, mesh.faces[f], center)) continue;
    slot[f] = static_cast<int>(facet.size());
    facet.push_back(static_cast<int>(f));
  }
  // Counting sort of the pixels by facet corner keeps them in ascending order within each.
  const auto place = [&](int code) {
    const auto [f, corner] = FacetCorner::Of(code);
    return slot[f] == kBehind ? kBehind : 3 * slot[f] + corner;
  };
  start.assign(3 * facet.size() + 2, 0);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int code = map.CodeAt(x, y);
      const int at = code < 0 ? kBehind : place(code);
      if (at != kBehind) ++start[at + 2];
    }
  }
  for (size_t c = 1; c < start.size(); ++c) start[c] += start[c - 1];
  pixel.resize(start.back());
  behind->clear();
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int code = map.CodeAt(x, y);
      if (code < 0) continue;
      const auto p = static_cast<uint32_t>(y) * static_cast<uint32_t>(width) + x;
      const int at = place(code);
      if (at == kBehind) {
        behind->push_back({p, map.InverseDepthAt(x, y)});
      } else {
        pixel[start[at + 1]++] = p;  // ends where the next one's begin
      }
    }
  }
  start.pop_back();
}

}  // namespace burin
