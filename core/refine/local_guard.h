// Takes back, vertex by vertex, what a round must not leave behind: spikes and folds.
//
// Against the mesh before the round, a vertex is at fault when
//   - a facet at it turned over: the angle between its normals before and after is above 90 degrees,
//   - an edge at it became too long: longer than max_stretch times its length before, or times the
//     level's pixel where that is larger,
//   - it moved more than max_move_px pixels of the level.
// Vertices at fault get the displacement that continues that of their neighbours (the membrane over
// those not at fault). Vertices that are still at fault then get no displacement. This repeats until
// no vertex is at fault, or all are back where they were.
#pragma once

#include <vector>

#include "core/mesh/mesh.h"
#include "core/support/options.h"

namespace burin {

// What becomes of parts that a round pushes through others (core/refine/crossing_guard.h): taken back, only
// counted, or neither.
enum class Crossings { kTakeBack, kReport, kOff };
inline Choices<Crossings> ChoicesOf(Crossings) {
  return {{Crossings::kTakeBack, "take_back"},
          {Crossings::kReport, "report"},
          {Crossings::kOff, "off"}};
}

struct GuardOptions {
  bool levels = true;       // judge every level by data held back (costs/held_back.h)
  double max_stretch = 8;   // 0 = any
  double max_move_px = 30;  // 0 = any
  bool inverted = true;
  Crossings crossings = Crossings::kTakeBack;
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
