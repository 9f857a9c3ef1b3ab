// Disjoint sets over 0 .. n-1 in a plain array of parents, started with parent[v] = v. Two sets are
// joined by parent[FindRoot(&parent, a)] = FindRoot(&parent, b).
#pragma once

#include <vector>

namespace burin {

// The representative of v's set. Shortens the way to it for the next call.
inline int FindRoot(std::vector<int>* parent, int v) {
  while ((*parent)[v] != v) v = (*parent)[v] = (*parent)[(*parent)[v]];
  return v;
}

}  // namespace burin
