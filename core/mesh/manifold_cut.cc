#include "core/mesh/manifold_cut.h"

#include <algorithm>
#include <numeric>

#include "core/support/union_find.h"

namespace burin {

std::vector<int> LabelCorners(const TriangleMesh& mesh) {
  struct Use {
    int low, high, corner_low, corner_high;
    bool forward;
  };
  std::vector<Use> uses;
  uses.reserve(mesh.faces.size() * 3);
  std::vector<int> label(mesh.faces.size() * 3);
  std::iota(label.begin(), label.end(), 0);
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    if (RepeatsVertex(mesh.faces[f])) continue;
    for (int c = 0; c < 3; ++c) {
      const int a = mesh.faces[f][c];
      const int b = mesh.faces[f][(c + 1) % 3];
      const int corner_a = static_cast<int>(3 * f) + c;
      const int corner_b = static_cast<int>(3 * f) + (c + 1) % 3;
      if (a < b) {
        uses.push_back({a, b, corner_a, corner_b, true});
      } else {
        uses.push_back({b, a, corner_b, corner_a, false});
      }
    }
  }
  std::sort(uses.begin(), uses.end(), [](const Use& a, const Use& b) {
    if (a.low != b.low) return a.low < b.low;
    if (a.high != b.high) return a.high < b.high;
    return a.corner_low < b.corner_low;
  });
  for (size_t begin = 0; begin < uses.size();) {
    size_t end = begin + 1;
    while (end < uses.size() && uses[end].low == uses[begin].low &&
           uses[end].high == uses[begin].high) {
      ++end;
    }
    if (end - begin == 2 && uses[begin].forward != uses[begin + 1].forward) {
      label[FindRoot(&label, uses[begin].corner_low)] =
          FindRoot(&label, uses[begin + 1].corner_low);
      label[FindRoot(&label, uses[begin].corner_high)] =
          FindRoot(&label, uses[begin + 1].corner_high);
    }
    begin = end;
  }
  for (size_t c = 0; c < label.size(); ++c) label[c] = FindRoot(&label, static_cast<int>(c));
  return label;
}

}  // namespace burin
