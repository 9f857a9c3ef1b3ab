// Which facet each pixel sees, and which of those surface points a second view sees too: the
// regions Omega_ij of the paper, frozen while a solver runs.
//
// There is no depth bias. A pixel's facet is the closest one at its centre (core/visibility/facet_map.h). The
// point X on it is visible from view j when nothing lies between X and j, where X's own facet and facets that
// share a vertex with it and face j are not obstacles: on a consistently oriented surface those cannot hide X,
// only rounding can make a ray touch them. Four pixels of j around X's projection decide where they can. X is
// visible where none of them sees something nearer than X but that facet and those neighbours; an obstacle
// would have to be smaller than a pixel. X is hidden where all of them see something else that is nearer by
// eight pixel footprints; a gap would have to be smaller than a pixel. Elsewhere an Embree ray decides.
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/camera.h"
#include "core/scene/pairs.h"
#include "core/visibility/view_domain.h"

namespace burin {

class FacetRays;

class RayCaster {
 public:
  // Copies the mesh into an Embree scene (single precision, centred on the bounding box).
  explicit RayCaster(const TriangleMesh& mesh);
  ~RayCaster();
  RayCaster(const RayCaster&) = delete;
  RayCaster& operator=(const RayCaster&) = delete;

  // Visible and front-facing facets of every view with their pixels, and Omega_ij for the given
  // pairs. A pixel whose facet is seen from behind belongs to nothing. Omega_ij excludes points
  // whose projection lies less than `border_px` inside view j's image or whose facet does not face
  // j, and those on a pixel of i or j that masks[i] or masks[j] has zero (CV_8UC1 of the camera's
  // size, or empty; no masks at all: none). `others` gets the regions of `other_pairs`, per view,
  // from the same rays; the domains' pixels are theirs too.
  std::vector<ViewDomain> Cast(const std::vector<Camera>& cameras,
                               const std::vector<CameraPair>& pairs, double border_px,
                               const std::vector<cv::Mat>& masks = {},
                               const std::vector<CameraPair>& other_pairs = {},
                               std::vector<ViewPartners>* others = nullptr) const;

  // For each of `points` (on facet facets[k]): nothing that the camera sees lies between it and the camera.
  // visible[k] is 1 or 0; facets that face away from the camera give 0. The image's borders do not count.
  void PointsVisible(const Camera& camera, const std::vector<Eigen::Vector3d>& points,
                     const std::vector<int>& facets, std::vector<uint8_t>* visible) const;

 private:
  std::unique_ptr<FacetRays> rays_;
};

}  // namespace burin
