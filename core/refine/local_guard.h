// Takes back, vertex by vertex, what a round must not leave behind: spikes and folds.
//
// Against the mesh before the round, a vertex is at fault when
//   - a facet at it turned over: the angle between its normals before and after is above 90 degrees,
//   - an edge at it became more than max_stretch times as long as the longer of what it was and the
//     level's pixel,
//   - it moved more than max_move_px pixels of the level.
// Vertices at fault get the displacement that continues that of their neighbours (the membrane over
// those not at fault); vertices still at fault then get none, and so on until no vertex is or all
// stand where they stood.
#pragma once

#include <vector>

#include "core/mesh/mesh.h"
#include "core/support/options.h"

namespace burin {

struct GuardOptions {
  bool levels = true;       // judge every level by data held back (costs/held_back.h)
  double max_stretch = 8;   // 0 = any
  double max_move_px = 30;  // 0 = any
  bool inverted = true;
  void Describe(OptionSet* set);
};

struct LocalGuardReport {
  int inverted_facets = 0;
  int stretched_edges = 0;
  int far_vertices = 0;
  int reverted_vertices = 0;  // that do not stand where the round put them
};

// Both meshes have the same facets; `faces` and `neighbors` are theirs. `pixel` is a pixel of the
// level in the unit of the positions.
LocalGuardReport RevertFaults(const std::vector<Eigen::Vector3d>& before, const Adjacency& faces,
                              const Adjacency& neighbors, double pixel, const GuardOptions& options,
                              TriangleMesh* mesh);

}  // namespace burin
