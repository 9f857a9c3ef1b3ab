// Options of making a mesh to start from.
#pragma once

#include "core/support/options.h"

namespace burin {

// kDense: those of stereo beside the sparse ones.
enum class StartPoints { kDense, kSparse };
inline Choices<StartPoints> ChoicesOf(StartPoints) {
  return {{StartPoints::kDense, "dense"}, {StartPoints::kSparse, "sparse"}};
}

struct StartOptions {
  StartPoints points = StartPoints::kDense;
  // Sparse points.
  int min_views = 3;
  double min_angle_deg = 2;
  double max_error_px = 2;
  double merge_footprints = 0.7;
  // Dense points.
  int partners = 4;
  double min_stereo_angle_deg = 4;
  double max_stereo_angle_deg = 25;
  int agreeing_pairs = 2;
  int confirming_views = 1;
  int spacing_px = 8;
  // The cut.
  double sigma_spacing = 0;
  double quality = 1;
  // What is left of its surface.
  double max_edge_footprints = 0;
  int min_part_facets = 100;
  void Describe(OptionSet* set);
};

}  // namespace burin
