// Options of making a mesh to start from.
#pragma once

#include "core/support/options.h"

namespace burin {

enum class StartPoints { kSparse };
inline Choices<StartPoints> ChoicesOf(StartPoints) { return {{StartPoints::kSparse, "sparse"}}; }

struct StartOptions {
  StartPoints points = StartPoints::kSparse;
  // Sparse points.
  int min_views = 3;
  double min_angle_deg = 2;
  double max_error_px = 2;
  double merge_footprints = 0.7;
  // The cut.
  double sigma_spacing = 0;
  double quality = 1;
  // What is left of its surface.
  double max_edge_footprints = 0;
  int min_part_facets = 100;
  void Describe(OptionSet* set);
};

}  // namespace burin
