// Facets that pass through each other: where a surface crosses itself.
//
// Two facets cross when an edge of one passes from one side of the other's plane to the other side, through a
// point of the other. Only facets without a common vertex are compared: those with one fold into each other on
// any wrinkle. Facets that touch, or overlap within a plane, do not cross.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <vector>

#include "core/mesh/mesh.h"

namespace burin {

struct FacetPair {
  int first = 0;  // the smaller
  int second = 0;
};
inline bool operator==(const FacetPair& a, const FacetPair& b) {
  return a.first == b.first && a.second == b.second;
}

// What is within rounding of a plane or of an edge touches it.
bool FacetsCross(const std::vector<Eigen::Vector3d>& vertices, const Eigen::Vector3i& a,
                 const Eigen::Vector3i& b);

// Finds what crosses anywhere on a motion of the vertices. Any number of threads may ask.
class CrossingSearch {
 public:
  // The straight motion from `from` to `to`. `faces` must outlive the search. CHECKs that its indices are in range.
  CrossingSearch(const std::vector<Eigen::Vector3i>& faces,
                 const std::vector<Eigen::Vector3d>& from, const std::vector<Eigen::Vector3d>& to);
  ~CrossingSearch();
  CrossingSearch(const CrossingSearch&) = delete;
  CrossingSearch& operator=(const CrossingSearch&) = delete;

  // The pairs that cross where every vertex is at `now`, somewhere on its way; ascending. `some`, where given, are
  // different facets: only pairs with one of them.
  std::vector<FacetPair> Find(const std::vector<Eigen::Vector3d>& now,
                              const std::vector<int>* some = nullptr) const;

 private:
  class BoxTree;
  const std::vector<Eigen::Vector3i>& faces_;
  std::vector<Eigen::AlignedBox3f> boxes_;  // by facet
  std::unique_ptr<BoxTree> tree_;
};

// The pairs that cross as the mesh is.
std::vector<FacetPair> CrossingFacets(const TriangleMesh& mesh);

// The number of different facets in the pairs.
int CountFacets(const std::vector<FacetPair>& pairs);

}  // namespace burin
