#include "core/refine/refinement_options.h"

namespace burin {

void LevelOptions::Describe(OptionSet* set) {
  set->Add("level.count", &count, "Levels of the image pyramid, each half the size of the next", 1,
           12);
  set->Add(
      "level.min_side_px", &min_side_px,
      "Views whose images have a smaller side than this take no part in a level but the finest; "
      "levels with less than half of the pairs are left out",
      1, 1000000);
  set->Add("level.finest", &finest, "Finest level used: 0 = full resolution, 1 = half, ...", 0, 11);
  set->Add("level.rounds", &rounds,
           "Rounds of freezing visibility and solving, on the finest level", 1, 1000);
  set->Add("level.extra_rounds", &extra_rounds,
           "Rounds more on every level than on the next finer one", 0, 1000);
  set->Add("level.coarse_tolerance", &coarse_tolerance,
           "solver.function_tolerance on every coarser level", 0, 1);
  set->Add("level.max_facet_px", &max_facet_px,
           "Facets are split to this area in their sharpest view, square pixels of the level", 0.5,
           1e9);
  set->Add("level.max_edge_px", &max_edge_px,
           "Facets with a longer edge are split too, pixel footprints of the level: those seen "
           "obliquely, as on depth steps; 0 = any length",
           0, 1e9);
  set->Add("level.max_faces", &max_faces,
           "Facets are split no further when the mesh has this many; the log says so", 1, 2e9);
  set->Add("level.border_px", &border_px,
           "Surface points projecting nearer to the second image's border are left out, pixels", 0,
           1000);
}

void RemeshingOptions::Describe(OptionSet* set) {
  set->Add(
      "surface.remesh", &remesh,
      "Within the finest level: cut the surface anew into well-shaped facets, their size adapted "
      "to how it bends, or leave its facets");
  set->Add("surface.rounds", &rounds,
           "Of level.rounds, those after surface.remesh; one at least is before it", 1, 1000);
  set->Add(
      "surface.chord_px", &chord_px,
      "Largest distance between an edge and the surface that it spans, pixels of the view that "
      "shows it largest; 0 = all edges are surface.max_edge_px long",
      0, 100);
  set->Add("surface.min_edge_px", &min_edge_px,
           "No edge is made shorter for it than this, pixels; thin parts have shorter ones", 0.5,
           1000);
  set->Add("surface.max_edge_px", &max_edge_px, "Edges of flat surface, pixels", 0.5, 1000);
}

void RefinementOptions::Describe(OptionSet* set) {
  level.Describe(set);
  surface.Describe(set);
  solver.Describe(set);
  guard.Describe(set);
  cameras.Describe(set);
  set->Add("motion.type", &motion, "How vertices move: along their normal of the round, or freely");
  set->Add("motion.hidden", &hidden,
           "Vertices that a pair saw in an earlier round and none sees now: drawn together after "
           "each round, or keep their shape as those never seen do");
}

}  // namespace burin
