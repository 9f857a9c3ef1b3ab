#include "reconstruct/start_options.h"

namespace burin {

void StartOptions::Describe(OptionSet* set) {
  set->Add("start.points", &points, "the points that the mesh is made of");
  set->Add("start.min_views", &min_views, "sparse points that fewer views see are left out", 2,
           100);
  set->Add("start.min_angle_deg", &min_angle_deg,
           "sparse points are left out whose lines of sight all differ by less", 0, 180);
  set->Add(
      "start.max_error_px", &max_error_px,
      "sparse points are left out that on average project farther from where they were measured", 0,
      1e6);
  set->Add("start.partners", &partners, "views that each view is matched with, for dense points", 1,
           16);
  set->Add("start.min_stereo_angle_deg", &min_stereo_angle_deg,
           "views are not matched whose lines of sight to common points differ by less", 0, 180);
  set->Add("start.max_stereo_angle_deg", &max_stereo_angle_deg, "or by more", 0, 180);
  set->Add("start.agreeing_pairs", &agreeing_pairs,
           "matched pairs that a depth must come from, within one pixel of disparity", 1, 16);
  set->Add("start.confirming_views", &confirming_views,
           "other views whose own depth must agree with a dense point", 0, 100);
  set->Add("start.spacing_px", &spacing_px, "pixels between dense points", 1, 1000);
  set->Add("start.merge_footprints", &merge_footprints,
           "points nearer to each other become one; pixels at the nearest view", 0.01, 100);
  set->Add(
      "start.sigma_spacing", &sigma_spacing,
      "how far lines of sight may end from the surface, in spacings of the points; 0 = .25, .5 "
      "with dense points",
      0, 100);
  set->Add("start.quality", &quality, "weight of facets that the points around do not suggest", 0,
           100);
  set->Add("start.max_edge_footprints", &max_edge_footprints,
           "facets with a longer edge are dropped; pixels at the nearest view; 0 = 100, 4 "
           "start.spacing_px with dense "
           "points",
           0, 1e9);
  set->Add("start.min_part_facets", &min_part_facets, "parts of fewer facets are dropped", 1, 1e9);
}

}  // namespace burin
