// The options of the coarse-to-fine loop (core/refine/refinement.h).
#pragma once

#include <algorithm>

#include "core/refine/local_guard.h"
#include "core/scene/cameras_options.h"
#include "core/solve/solver_strategy.h"
#include "core/support/options.h"

namespace burin {

struct LevelOptions {
  int count = 5;                   // images at 2^-(count-1), ..., 1/2, 1 of their size
  int min_side_px = 64;            // views with smaller images than this are left out of a level
  int finest = 0;                  // 0 = full resolution, 1 = half, ...
  int rounds = 2;                  // on the finest level
  int extra_rounds = 2;            // more on every level than on the next finer one
  double coarse_tolerance = 1e-4;  // solver.function_tolerance on the others
  double max_facet_px = 16;        // facets are split down to this area, square pixels of the level
  double max_edge_px = 12;         // and edges to this length, pixel footprints of the level
  int max_faces = 50'000'000;      // splitting stops there
  double border_px = 3;            // second-view points nearer to the border are left out
  void Describe(OptionSet* set);

  int more_on_finest = 0;  // rounds; of terms that ask for them, no option by itself

  int RoundsAt(int level) const {
    return rounds + (level - finest) * extra_rounds + (level == finest ? more_on_finest : 0);
  }
};

// Whether the surface is cut into facets anew within the finest level (core/refine/remeshing.h): by sizes adapted to its bends.
enum class SurfaceFacets { kNone, kAdapted };
inline Choices<SurfaceFacets> ChoicesOf(SurfaceFacets) {
  return {{SurfaceFacets::kNone, "none"}, {SurfaceFacets::kAdapted, "adapted"}};
}

struct RemeshingOptions {
  SurfaceFacets remesh = SurfaceFacets::kAdapted;
  int rounds = 1;          // of level.rounds, those after it
  double chord_px = 0.15;  // of EdgeLengthOptions
  double min_edge_px = 4.5;
  double max_edge_px = 7.5;
  void Describe(OptionSet* set);

  // Of `rounds` of the finest level, those before it.
  int RoundsBefore(int all) const {
    return remesh == SurfaceFacets::kNone ? all : std::max(1, all - rounds);
  }
};

// What becomes of vertices that a pair saw in an earlier round and none sees now
// (core/refine/hidden_folds.h): drawn together, or they keep their shape as those never seen do.
enum class HiddenVertices { kRelax, kKeep };
inline Choices<HiddenVertices> ChoicesOf(HiddenVertices) {
  return {{HiddenVertices::kRelax, "relax"}, {HiddenVertices::kKeep, "keep"}};
}

struct RefinementOptions {
  LevelOptions level;
  CamerasOptions cameras;
  RemeshingOptions surface;
  SolverOptions solver;
  GuardOptions guard;
  Motion motion = Motion::kNormal;
  HiddenVertices hidden = HiddenVertices::kRelax;
  void Describe(OptionSet* set);
};

}  // namespace burin
