// Which facet each pixel sees: drawn with a depth buffer, without rays.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/camera.h"
#include "core/visibility/facet_rows.h"

namespace burin {

// The facet, from whatever side, whose surface the ray through each pixel's centre meets first beyond the camera's
// near_depth; -1 for none. With h_k = K (R V_k + t) the homogeneous image points of a facet's corners,
//
//   u_k(x, y) = (h_(k+1) x h_(k+2)) . (x, y, 1) / det [h_0 h_1 h_2],   1/t = u_0 + u_1 + u_2,
//
// a pixel is on the facet where no u_k is negative (Olano and Greer 1997): facets that reach behind the camera need no
// clipping. Of facets that meet at an edge exactly one has a centre on it where both are seen from the same side. Of
// facets at the same depth (single precision of 1/t) the first one is seen. Facets that are not finite, or edge-on, are
// not seen. `inverse_depth`, unless null, gets 1/t of what is seen, 0 for nothing.
cv::Mat1i FacetMap(const TriangleMesh& mesh, const Camera& camera,
                   cv::Mat1f* inverse_depth = nullptr);

// A facet and the one of its corners with the largest u_k at a pixel (of equal ones the first), as a number.
struct FacetCorner {
  int facet;
  int corner;
  static FacetCorner Of(int code) { return {code / 4, code % 4}; }
  int Code() const { return 4 * facet + corner; }
};

// FacetCorner codes of what FacetMap() shows, -1 for none, and 1/t of it, 0 for none. CHECKs that the mesh has less than
// 2^29 facets.
struct CornerMap {
  CornerMap(const TriangleMesh& mesh, const Camera& camera);
  int CodeAt(int x, int y) const { return CodeOf(pixels[y * stride + x]); }
  float InverseDepthAt(int x, int y) const { return InverseDepthOf(pixels[y * stride + x]); }

  int width;
  int height;
  size_t stride;                // of a row
  std::vector<int64_t> pixels;  // a depth buffer (core/visibility/facet_rows.h)
};

}  // namespace burin
