#include "core/visibility/view_domain.h"

#include <algorithm>
#include <limits>

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
  struct Box {
    int left = std::numeric_limits<int>::max();
    int top = std::numeric_limits<int>::max();
    int right = 0;
    int bottom = 0;
  };
  std::vector<Box> boxes(facet.size());
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int code = map.CodeAt(x, y);
      const int at = code < 0 ? kBehind : place(code);
      if (at == kBehind) continue;
      ++start[at + 2];
      Box& box = boxes[at / 3];
      box.left = std::min(box.left, x);
      box.right = std::max(box.right, x);
      box.top = std::min(box.top, y);
      box.bottom = y;
    }
  }
  for (size_t c = 1; c < start.size(); ++c) start[c] += start[c - 1];
  constexpr int kMost = std::numeric_limits<uint16_t>::max();
  const bool near = std::all_of(boxes.begin(), boxes.end(), [](const Box& box) {
    return box.right - box.left < PixelRange::kNear && box.bottom - box.top < PixelRange::kNear &&
           box.left <= kMost && box.top <= kMost;
  });
  boxes_.clear();
  for (size_t k = 0; near && k < boxes.size(); ++k) {
    boxes_.push_back({static_cast<uint16_t>(boxes[k].left), static_cast<uint16_t>(boxes[k].top)});
  }
  boxes_.shrink_to_fit();
  near_.resize(near ? start.back() : 0);
  far_.resize(near ? 0 : start.back());
  behind->clear();
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int code = map.CodeAt(x, y);
      if (code < 0) continue;
      const auto p = static_cast<uint32_t>(y) * static_cast<uint32_t>(width) + x;
      const int at = place(code);
      if (at == kBehind) {
        behind->push_back({p, map.InverseDepthAt(x, y)});
        continue;
      }
      const uint32_t entry = start[at + 1]++;  // ends where the next one's begin
      if (near) {
        const BoxCorner& corner = boxes_[at / 3];
        near_[entry] =
            static_cast<uint16_t>(PixelRange::kNear * (y - corner.row) + (x - corner.column));
      } else {
        far_[entry] = p;
      }
    }
  }
  start.pop_back();
}

}  // namespace burin
