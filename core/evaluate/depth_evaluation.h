// Scores a mesh by what the cameras see of it, as Strecha et al. do ("On benchmarking camera
// calibration and multi-view stereo for high resolution imagery", 2008). In each view the depth maps of
// the mesh and of the truth are compared pixel by pixel, in units of the truth's own accuracy.
//
// Protocol
//  1. For each view, D(x) is the camera z of the mesh's first surface on the ray through the centre
//     of pixel x. D*(x) is that of the truth, rendered from a truth mesh or taken from a depth map.
//     Points are not splatted: a truth cloud needs depth maps.
//  2. Truth pixels have a D*. Covered pixels have a D too; there e(x) = D(x) - D*(x).
//         MAE = mean |e|,  RMSE = sqrt(mean e^2)   over covered pixels of all views,
//         covered share = covered / truth pixels.
//  3. With sigma, the standard deviation of the truth: the number of truth pixels with
//     (k - 1) sigma < |e| <= k sigma for k = 1..10 (e = 0 is in the first), with |e| > 10 sigma, and
//     without a D (missing). They add up to all truth pixels.
// Deviation: the paper estimates a sigma per pixel from the laser's; here it is one constant.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/scene.h"
#include "core/support/options.h"

namespace burin {

struct StrechaOptions {
  bool run = false;
  double sigma = 0;  // in unit; 0 = no histogram

  void Describe(OptionSet* set);
};

// Of the pixels of one view or of several, lengths in world units.
struct DepthErrors {
  std::int64_t truth_pixels = 0;
  std::int64_t covered_pixels = 0;
  double sum_of_sizes = 0;                       // of |e|
  double sum_of_squares = 0;                     // of e^2
  std::array<std::int64_t, 10> within_sigmas{};  // [k - 1]: (k - 1) sigma < |e| <= k sigma
  std::int64_t beyond_sigmas = 0;                // |e| > 10 sigma

  std::int64_t MissingPixels() const { return truth_pixels - covered_pixels; }
  double CoveredShare() const;  // 0 without truth pixels
  double Mae() const;           // 0 without covered pixels
  double Rmse() const;          // 0 without covered pixels
  void Add(const DepthErrors& other);
};

struct DepthEvaluation {
  double sigma = 0;  // world units; 0 = no histogram
  DepthErrors total;
  std::vector<std::string> names;  // of the views with truth pixels
  std::vector<DepthErrors> views;  // of each of them
};

// Steps 2 and 3 for one view: maps of camera z in world units, 0 = no surface, of the same size
// (CHECKed). `sigma` in world units, 0 = no histogram.
DepthErrors CompareDepth(const cv::Mat1f& mesh_depth, const cv::Mat1f& truth_depth, double sigma);

// The truth's depth map in view i; empty when there is none. It may be smaller than the image by a
// constant factor; the mesh is rendered at its size.
using TruthDepth = std::function<cv::Mat1f(int view)>;

// The protocol above; mesh and cameras in the frame of the truth, `sigma` in world units. Throws
// InputError when no pixel of any view has a true depth.
DepthEvaluation EvaluateDepth(const TriangleMesh& mesh, const Scene& scene,
                              const TruthDepth& truth_depth, double sigma);

}  // namespace burin
