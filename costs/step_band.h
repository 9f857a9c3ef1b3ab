// Leaves pixels beside a depth step out of Omega_ij where the surface has better evidence.
//
// Masks (costs/occlusion_mask.h) trust the mesh's own steps. While silhouettes are a pixel or two off,
// pixels beside a step show another surface than the mesh says, in the reference view and in the second
// one alike. Photographs mix two surfaces in the pixel of the step anyway. Pixel p of Omega_ij is near a
// step when p, or the pixel of view j that its surface point falls into, is within `band_px` of a pixel
// of a step of its view's depth map.
//
// Leaving all of them out would lose what has no other evidence: rims seen at a grazing angle, bars a
// few pixels wide. So a facet keeps all its pixels unless its patch (the facets that share a vertex with
// it) is seen well without them: C >= evidence * A. C are the patch's remaining pixels, summed over all
// pairs; A are its pixels in the views that show each of its facets largest. In other words, about
// `evidence` pairs see the patch clear of all steps. Facets of the patch count once per vertex shared.
//
// There is no band on the first level of a run: it would be as wide as whole bars, and silhouettes get
// their first correction there. The band is discrete and frozen for a round, like Omega_ij itself.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/camera.h"
#include "core/visibility/visibility.h"
#include "costs/occlusion_mask.h"

namespace burin {

// Distance from each pixel to the nearest one of a step, 0 on it; without a step a very large number. Of two neighbours (side by
// side or one above the other) both are of a step when neither's depth is within `plane_px` pixel
// footprints of the plane of the other's facet, or when only one has a surface and that is not of
// `open_border` (1 for such pixels; empty: none is).
cv::Mat1f StepDistances(const DepthPlanes& planes, const std::vector<uint8_t>& open_border,
                        double plane_px);

// 1 for the pixels within `band_px` of a pixel of such a step, row-major.
std::vector<uint8_t> NearSteps(const DepthPlanes& planes, const std::vector<uint8_t>& open_border,
                               double plane_px, double band_px);

// 1 for the pixels of facets at an open border of the mesh (`boundary`: its vertices), row-major:
// where the mesh was cut, its end in the picture says nothing about the photographed surface.
std::vector<uint8_t> OpenBorderPixels(const ViewDomain& domain, const TriangleMesh& mesh,
                                      const std::vector<char>& boundary);

// Omega_ij of every view's `partners`, in the pixels of its domain, without those near a step, as
// above. near_steps[i] is NearSteps of view i, or empty for a view whose depths are not known: it has
// no steps then.
std::vector<PartnerBits> WithoutSteps(const std::vector<ViewDomain>& domains,
                                      const std::vector<const ViewPartners*>& partners,
                                      const std::vector<Camera>& cameras, const TriangleMesh& mesh,
                                      const std::vector<std::vector<uint8_t>>& near_steps,
                                      double evidence);

}  // namespace burin
