// How well the contour of the surface fits the outline of the object's mask in one view of a round.
//
//   E = W/2 sum_p rho(e_p^2),   e_p = C_p - M_p,   rho(s) = c^2 log(1 + s / c^2)
//
// C and M: the share of pixel p that the surface covers, and the object's mask, both blurred by a Gaussian G of standard
// deviation sigma. W = 2 sqrt(pi) sigma, so that a straight contour d pixels beside its outline costs d^2/2 a pixel of its
// length while d is small. Units are pixels of the level.
//
// Frozen in a round: the contour (core/visibility/mesh_cover.h) as samples s with length l, unit normal n pointing outwards,
// place x on an edge (a, b) and share t of the way along it. At other positions of the vertices
//
//   u_s = n . ((1 - t) pi(V_a) + t pi(V_b) - x),   C_p = C_p(start) + sum_s l int_0^u G(p - x - v n) dv
//
// the area that the contour sweeps, exact where it is straight. So for edge (a, b) in this view, with n' = D pi^T n at V
//
//   dE/dV_a = sum_s k (1 - t) n'_a,   k = W l sum_p rho' e_p G_ps,   G_ps = G(p - x - u n)
//   H(a, b) = sum_s h (1 - t) t n'_a n'_b^T,   h = W l sum_p rho' G_ps S_p,   S_p = sum_s l G_ps
//
// H is the Gauss-Newton matrix majorised: sum_p rho' (sum_s l G u)^2 <= sum_s l u^2 sum_p rho' G S. Equal where
// neighbouring samples move alike. E is shared out among the samples by l G_ps / S_p, which makes k^2 <= 2 E_s h.
//
// The contour integral is that of Delaunoy and Prados, "Gradient flows for optimizing triangular mesh-based surfaces"
// (IJCV 2011), for a mesh of which the outside is not known.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "core/scene/pyramid.h"
#include "core/visibility/mesh_cover.h"

namespace burin {

// Of one edge in one view, in displacements along the outward normal of the edge's image.
struct RimSums {
  double energy = 0;
  double slope[2] = {0, 0};         // by vertex a, b
  double curvature[3] = {0, 0, 0};  // (a, a), (a, b), (b, b)
};

class SilhouetteView {
 public:
  struct Rim {
    int edge;  // of the EdgeFacets
    int a, b;  // vertices
    Eigen::Vector2d outward;
    int begin, end;     // samples
    bool thin = false;  // the surface is, at one of them
  };
  // What the contour says at the round's start.
  struct Fit {
    double contour_px = 0;  // its length
    double signed_px = 0;   // median; > 0: the surface lies outside its outline
    double unmatched = 0;   // share of its length without an outline near it: that has no say
    double intersection_share = 0;  // of surface and mask, of their union around the contour
  };

  // The contour. `view` has an object mask, and outlives this until Compare() has been called.
  SilhouetteView(const LevelView& view, const TriangleMesh& mesh, const EdgeFacets& edges,
                 int level);
  // Leaves out the rims at vertices that `without` has, and compares surface and mask along the others. Once, before
  // anything is evaluated.
  void Compare(const std::vector<char>& without);

  const std::vector<Rim>& rims() const { return rims_; }
  const Camera& camera() const { return camera_; }
  const Fit& fit() const { return fit_; }

  // Of every rim at these positions; returns the energy of pixels that no sample reaches any more.
  double Evaluate(const std::vector<Eigen::Vector3d>& vertices, std::vector<RimSums>* sums) const;

 private:
  struct Sample {
    Eigen::Vector2d point;
    double along, length;
    cv::Rect box;  // of pixels of region_
  };
  void TakeContour(const EdgeFacets& edges);
  void FindRegion();
  void CompareAtStart();
  void Judge(const cv::Mat1f& difference);
  // Calls use(pixel, across, along) for the pixels that count of a sample's box: across its contour, outwards, and along it.
  template <typename Use>
  void ForEachPixel(const Sample& sample, const Eigen::Vector2d& outward, const Use& use) const;

  const LevelView* view_;
  std::optional<MeshCover> cover_;  // until compared
  Camera camera_;
  cv::Rect region_;  // of the image
  std::vector<Rim> rims_;
  std::vector<Sample> samples_;
  std::vector<char>
      counts_;  // by pixel of the region: some sample reaches it, and the mask is known there
  std::vector<double> start_;  // likewise: e_p, plus what the samples will take away for u = 0
  Fit fit_;
};

}  // namespace burin
