// Pictures of what the photometric energy measures: the second image warped through the surface
// into the reference, and what remains of the difference.
#pragma once

#include <opencv2/core.hpp>

#include "core/energy_term.h"

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

}  // namespace burin
