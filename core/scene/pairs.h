// A directed camera pair: view `second` is warped into view `reference` through the surface.
// (i, j) and (j, i) are different pairs; both may be selected.
#pragma once

#include <string>
#include <vector>

namespace burin {

struct Scene;

struct CameraPair {
  int reference = -1;  // i: its pixels are the domain of the photometric error
  int second = -1;     // j: its image is sampled at the projections
};

inline bool operator==(const CameraPair& a, const CameraPair& b) {
  return a.reference == b.reference && a.second == b.second;
}

// Of a view, for windows of tracks through the mesh (core/cameras/mesh_tracks.h).
constexpr int kMatchingPartners = 6;

// What is wrong with pairs that come from outside: a view that the scene has not, a view paired with
// itself or a pair that repeats. "pairs[1] = a.jpg, b.jpg: appears twice"; empty when nothing is.
std::string PairsFault(const std::vector<CameraPair>& pairs, const Scene& scene);

}  // namespace burin
