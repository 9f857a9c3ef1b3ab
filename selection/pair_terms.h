// How good a camera pair is for refining the surface that it sees: the terms of the paper's section
// "Model-based Camera Pairs Selection". First come measures at one surface point x with unit normal n,
// then the energies of their means over Omega_ij (pair_survey.h integrates).
//
//   E_BPV = mu_p E_p + mu_o E_o + mu_s E_s + mu_r E_r,    every term in [-1, 0], less is better
//   E_p = -exp(-(P - 50 deg)^2 / (2 sigma_p^2))    P: mean parallax                  (parallax)
//   E_o = -A(Omega_ij) / A                                                           (overlap)
//   E_s = -exp(-S^2 / (2 sigma_s^2))               S: mean oriented angle difference (symmetry)
//   E_r = -exp(-R^2 / (2 sigma_r^2))               R: mean discrepancy of resolution (resolution)
//
// Where the paper's printed formula contradicts its own text, both forms are measured and a switch
// chooses. The defaults are the corrected forms.
#pragma once

#include <Eigen/Core>

#include "core/scene/camera.h"

namespace burin {

// What one surface point, or the mean over Omega_ij, says about the pair (i, j).
struct PairMeasure {
  double area = 0;                 // A(Omega_ij) / A(I_i), in [0, 1]; 0 = the pair shares nothing
  double area_in_range = 0;        // the part of it under a parallax in the surveyed range
  double parallax_deg = 0;         // angle at x between the directions to c_i and c_j
  double symmetry_deg[2][2] = {};  // OrientedAngleDifferenceDeg [form][mean]: form 1 = printed;
                                   // mean 0 of magnitudes, 1 = printed, of signed values
  double resolution = 0;           // |rho_i - rho_j| / rho_i, rho = distance / focal length
  double resolution_printed = 0;   // |rho_i - rho_j| / |c_i x|, per pixel
};

// A surface point x with unit normal n as one view sees it: what every measure of a pair is made of.
struct PointSight {
  // `focal_px` is FocalPx() of the view's camera, `center` its centre.
  PointSight(const Eigen::Vector3d& center, double focal_px, const Eigen::Vector3d& x,
             const Eigen::Vector3d& n);

  Eigen::Vector3d toward;  // c - x
  double distance;         // |c - x|
  double rho;              // distance / focal length
  double height;           // (c - x) . n
  double normal_deg;       // angle between n and c - x
};

// Geometric mean of fx and fy.
double FocalPx(const Camera& camera);

// Angle at x between the directions to the two camera centres, degrees in [0, 180].
double ParallaxDeg(const PointSight& i, const PointSight& j);

// With a_i, a_j the angles between n and the directions to the centres, and s = 1 when both
// centres are on the same side of the plane that contains n and x and is perpendicular to the
// plane of n and c_i (ties: the same), else -1:
//   corrected (a_i + s a_j) / 2: zero when the cameras stand symmetrically about the normal
//   printed   s (a_i - a_j) / 2: as small for two cameras that stand side by side
double OrientedAngleDifferenceDeg(const PointSight& i, const PointSight& j, bool printed);

// |rho_i - rho_j| / rho_i: the share by which pixels of the two views differ in size at x. As printed the
// divisor is the distance, which leaves a number of the order of one over the focal length.
double ResolutionDiscrepancy(const PointSight& i, const PointSight& j, bool printed);

struct BpvOptions {
  bool use_parallax = true;
  bool use_overlap = true;
  bool use_symmetry = true;
  bool use_resolution = true;
  double weight_parallax = 0.25;    // mu_1
  double weight_overlap = 0.25;     // mu_2
  double weight_symmetry = 0.5;     // mu_3
  double weight_resolution = 0.25;  // mu_4
  double reference_parallax_deg = 50;
  double sigma_parallax_deg = 45;
  double sigma_symmetry_deg = 45;
  double sigma_resolution = 0.25;
  bool overlap_of_image = false;    // A = A(I_i), as printed, instead of the pixels of view i that
                                    // see the mesh
  bool printed_symmetry = false;    // the printed oriented angle difference
  bool signed_symmetry = false;     // its mean with signs, as printed. s flips where c_i is on the
                                    // normal: seen frontally, any partner averages to symmetric
  bool printed_resolution = false;  // the printed discrepancy
};

struct PairEnergies {
  double parallax = 0;    // E_p
  double overlap = 0;     // E_o
  double symmetry = 0;    // E_s
  double resolution = 0;  // E_r
  double total = 0;       // E_BPV over the terms in use
};

// Gaussian of a mean: -exp(-(value - reference)^2 / (2 sigma^2)).
double GaussianEnergy(double value, double reference, double sigma);

// The mean that E_s is made of, degrees.
double SymmetryDeg(const PairMeasure& measure, const BpvOptions& options);

// `seen` is the share of view i's image that sees the front of the mesh. All zero for a pair that
// shares nothing.
PairEnergies EvaluatePair(const PairMeasure& measure, double seen, const BpvOptions& options);

}  // namespace burin
