// How long the edges of a remeshed surface should be: short where the surface bends, long where it is flat, both
// in pixels of the view that shows it largest.
#pragma once

#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/camera.h"

namespace burin {

struct EdgeLengthOptions {
  // The largest distance between an edge and the surface that it spans, in pixels: on a surface of curvature k
  // (1/px) edges are sqrt(8 chord_px / k) long, within the bounds below. 0: they are max_px long everywhere.
  double chord_px = 0;
  double min_px = 4;
  double max_px = 7;
  // An edge spans no more than this much of a bend, whatever min_px says, so that a rod of a pixel's radius stays
  // round; but no length is below floor_px. 0: any.
  double max_turn_deg = 60;
  double floor_px = 1;
  // Lengths grow by no more than this much a unit of length along the surface.
  double gradation = 0.4;
  // Normals are smoothed this often before curvature is read from them.
  int smoothing_rounds = 3;
};

// Width of a pixel on the surface at each vertex, world units: camera footprint / sqrt(cos), the smallest over the
// views where a facet at the vertex counts as visible, cos being of the angle between its normal and the view, at
// least `min_cos`. `face_visible_in_view[f][i]` says whether view i sees face f; null: all that face it. What
// no view sees has `unseen_factor` times the value of the nearest vertex that has one; 0 everywhere when no
// view sees anything.
std::vector<double> PixelWidths(const TriangleMesh& mesh, const std::vector<Camera>& cameras,
                                const std::vector<std::vector<char>>* face_visible_in_view,
                                double unseen_factor = 2.5, double min_cos = 0.3);

// Curvature at each vertex, 1/world unit: the larger principal one in size, from how normals smoothed
// `smoothing_rounds` times turn over the facets around it (Rusinkiewicz, "Estimating curvatures and their
// derivatives on triangle meshes", 2004), averaged by area.
std::vector<double> MaxCurvatures(const TriangleMesh& mesh, int smoothing_rounds);

// Wanted edge length at each vertex, world units. `pixel_width`, world units, > 0, as PixelWidths makes them.
std::vector<double> EdgeLengths(const TriangleMesh& mesh, const std::vector<double>& pixel_width,
                                const EdgeLengthOptions& options);

}  // namespace burin
