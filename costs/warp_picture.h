// Pictures of what the photometric energy measures: the second image warped through the surface into the
// reference, the difference that remains, and what occlusion masks change.
#pragma once

#include <opencv2/core.hpp>

#include "core/solve/energy_term.h"
#include "costs/photometric_energy.h"

namespace burin {

struct WarpPicture {
  cv::Mat1f warped;          // W, grey levels; 0 where the pixel is not in Omega_ij
  cv::Mat1b valid;           // 255 in Omega_ij
  cv::Mat1f residual;        // |I - (gain W + offset)|, gain and offset fitted over Omega_ij
  double mean_residual = 0;  // over Omega_ij, grey levels; 0 when it is empty
};

// `partner` indexes domain.seconds; mesh, views and domain are of one frozen round.
WarpPicture MakeWarpPicture(const std::vector<LevelView>& views, int reference,
                            const ViewDomain& domain, int partner, const TriangleMesh& mesh);

// 1 - ZNCC of the window around every pixel of a pair, as the energy counts it; 0 where the window
// does not count; `second` is the warped view. With `masks` of the reference view, over the taps they keep.
cv::Mat1f WindowErrors(const LevelView& view, const LevelView& second, const WarpPicture& pair,
                       const PhotometricOptions& options, const WindowMasks* masks);

// The reference image in grey, redder the more taps the window around a pixel keeps (the paper's
// figure of masks); grey where there is no surface.
cv::Mat3b KeptTapsPicture(const cv::Mat1f& image, const ViewDomain& domain,
                          const WindowMasks& masks);

}  // namespace burin
