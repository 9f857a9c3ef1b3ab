// Omega_ij of one pair: what is seen from view j of the surface points that view i sees
// (core/visibility/visibility.h says what hides a point).
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/camera.h"
#include "core/visibility/facet_rays.h"
#include "core/visibility/view_domain.h"

namespace burin {

// What is kept of a view for all pairs.
struct ViewPixels {
  Camera camera;
  cv::Mat mask;                    // empty = none
  ViewDomain domain;               // without partners
  std::vector<PixelDepth> behind;  // where it sees a facet from behind
};

// What the second view of pairs sees, as maps, which have at least two rows and columns. One object serves view after view
// and keeps its memory.
struct SecondView {
  void Look(const TriangleMesh& mesh, const ViewPixels& pixels);

  Camera camera;
  cv::Mat mask;                 // empty = none
  std::vector<uint8_t> facing;  // FacingFacets() of its centre
  cv::Mat1i facet_map;          // of the facets that face it; -1 elsewhere
  cv::Mat1f inverse_depth;      // of what is seen, from whatever side; 0 = nothing
  // Each two of the facets at a pixel, right of it, below and right below share a vertex.
  cv::Mat1b connected;

 private:
  void Connect(const TriangleMesh& mesh, int row);
};

// Sets the bits of partner `partner` in the pixels of `first` that belong to Omega_ij; returns how many.
int64_t CastPair(const FacetRays& rays, const ViewPixels& first, const SecondView& second,
                 double border_px, size_t partner, PartnerBits* bits);

}  // namespace burin
