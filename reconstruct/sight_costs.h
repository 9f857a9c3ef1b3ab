// What lines of sight and the shape of the tetrahedra say about a surface between them, as costs of a cut (Labatut,
// Pons, Keriven, "Efficient multi-view reconstruction of large-scale scenes using interest points, Delaunay
// triangulation and graph cuts", ICCV 2007, and "Robust and efficient surface reconstruction from range data",
// CGF 2009):
//
//   a facet between a point and a camera that sees it, d in front of the point:    1 - exp(-d^2 / 2 sigma^2)
//   a facet on the same line, d <= 3 sigma behind the point:                       1 - exp(-d^2 / 2 sigma^2)
//   the cell 3 sigma behind the point, where it is outside:                        1
//   the cell of the camera must be outside; for a camera off the hull, the infinite cells of the facets that it sees
//   every facet:             quality (1 - min(cos phi, cos psi)), both ways
// phi and psi are the angles between the facet and the circumscribed spheres of its two cells; the cosine is from the
// cell's side, negative where the circumcentre is beyond the facet.
//
// Deviations from the papers: the camera's cell has no finite weight but must be outside; the quality term takes the
// cosine with its sign.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "reconstruct/minimum_cut.h"
#include "reconstruct/sighted_points.h"

namespace burin {

// Median over the points of the first quartile of the lengths of the edges at each, world units.
double PointSpacing(const std::vector<Eigen::Vector3d>& points, const Tetrahedra& tetrahedra);

struct SightCosts {
  CutCosts costs;
  long lines = 0;
  long lost = 0;  // lines that touch points on their way and were not followed to the end
};

// `centers` of the cameras; `sigma` in world units, positive.
SightCosts CostsOfSights(const SightedPoints& points, const Tetrahedra& tetrahedra,
                         const std::vector<Eigen::Vector3d>& centers, double sigma, double quality);

}  // namespace burin
