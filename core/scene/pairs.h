// A directed camera pair: view `second` is warped into view `reference` through the surface.
// (i, j) and (j, i) are different pairs; both may be selected.
#pragma once

#include <vector>

namespace burin {

struct CameraPair {
  int reference = -1;  // i: its pixels are the domain of the photometric error
  int second = -1;     // j: its image is sampled at the projections
};

inline bool operator==(const CameraPair& a, const CameraPair& b) {
  return a.reference == b.reference && a.second == b.second;
}

}  // namespace burin
