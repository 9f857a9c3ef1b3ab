// Where pixels become a gradient: one camera pair over one tile of the reference image.
//
// For every pixel p of the tile in Omega_ij, with N(p) the square window, M_p the taps of N(p) in
// Omega_ij that p's occlusion mask keeps (costs/occlusion_mask.h), a = I|M_p and b = W|M_p made
// zero-mean, n = |M_p|, and the variance floor e^2:
//
//   s_a^2 = |a|^2 + n e^2,  s_b^2 = |b|^2 + n e^2,  z_p = a.b / (s_a s_b)
//   E    = sum_p  omega_p (1 - z_p)                         omega_p = s_a^2 / (s_a^2 + n nu)
//   dE/dW(y) = - sum_{p : y in M_p} omega_p (a(y) / (s_a s_b) - z_p b(y) / s_b^2)
//   w(y) = sum_{p : y in M_p} omega_p / s_b^2               (the majorised Gauss-Newton weight)
//
// (Romanoni & Matteucci, eq. 2 with err = 1 - ZNCC. The sum runs over all windows that contain y;
// only so is it the gradient of E.) W(y) = J(q(y)) with q(y) = A (x,y,1) + e s(y) in homogeneous
// coordinates, and s = 1/depth along the fixed ray of y. So dW/ds = grad J . dq/ds =: D(y). For each
// pixel of the reference image, these fields are added up here:
//
//   cost(y)      += omega_y (1 - z_y)
//   share(y)     += sum_{p : y in M_p} omega_p (1 - z_p) / |M_p|
//   slope(y)     += dE/dW(y) D(y) = dE/ds(y)
//   curvature(y) += w(y) D(y)^2.
//
// All window sums are separable box sums streamed over rows; nothing per pair is kept. Windows whose
// mask drops a tap are the exception: they are summed tap by tap, and pixels gather their share of dE/dW
// from them tap by tap. Held constant: Omega_ij, the masks, the reference image, the noise constants.
//
// Follow a pixel: costs/pair_kernel.cc streams the rows of a tile through WarpRow
// (pair_kernel_warp-inl.h: W and D), SumRow and ScoreRow (pair_kernel_windows-inl.h: window sums, z
// and its factors), ScoreMaskedWindows (pair_kernel_masked-inl.h) and DifferentiateRow
// (pair_kernel_derivatives-inl.h: slope and curvature).
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/visibility/partner_bits.h"
#include "costs/occlusion_mask.h"
#include "costs/spline_image.h"

namespace burin {

template <typename T>
struct PairInput {
  int width = 0;  // of the reference image
  int height = 0;
  const float* image = nullptr;            // I, row-major, grey levels in any unit
  float grey_offset = 0;                   // subtracted from I; the second image has it subtracted
  const T* inverse_depth = nullptr;        // s, row-major; any value outside the domain
  PartnerPixels domain;                    // Omega_ij
  const SplineImage<T>* second = nullptr;  // J - offset
  double warp[9] = {};                     // A, row-major: K_j R_j R_i^T K_i^-1
  double epipole[3] = {};                  // e = K_j (R_j c_i + t_j)
  int radius = 2;                          // window (2 radius + 1)^2
  double variance_floor = 0;               // e^2, squared units of I and J per tap
  double reliability_noise = 0;            // nu, squared units per tap; 0 switches omega to 1
  int min_taps = 1;                        // windows with fewer taps are left out
  const WindowMasks* masks = nullptr;      // of the reference view; null = all windows are full
  bool full_below = false;                 // masked windows with fewer taps are used in full
  bool full_thin = false;                  // only the thin ones of them
};

// Per-pixel sums over the pairs of one reference view.
template <typename T>
struct PixelFields {
  // Of a pixel, one after the other, so that one read has them all; without derivatives the cost alone.
  enum Sum {
    kCost,       // omega (1 - z) of the window centred here
    kSlope,      // dE/ds
    kCurvature,  // w D^2
    kShare,      // of the cost of all windows that have this pixel as a tap: cost / n of each
    kSumCount
  };
  int per_pixel = kSumCount;  // or 1
  std::vector<T> sums;
  std::vector<T> weight;  // omega of the windows centred here; left out where it is empty
  const T* Of(size_t pixel) const { return sums.data() + pixel * per_pixel; }
  void Resize(size_t size, bool derivatives, bool weights);  // what is in them is not touched
  void Clear(size_t begin, size_t end);                      // zeros in pixels [begin, end)
};

// What the derivatives by cameras need of a pixel for one pair, one after the other; set in Omega_ij alone.
template <typename T>
struct PairFields {
  enum Field {
    kDerivative,  // dE/dW
    kWeight,      // w
    kGradientX,   // of J at q, per pixel
    kGradientY,
    kCount
  };
  std::vector<T> values;  // of all pixels of the view
  const T* Of(size_t pixel) const { return values.data() + pixel * kCount; }
};

struct Tile {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // pixels [x0, x1) x [y0, y1)
};

template <typename T>
struct KernelRows;

// Works on a tile at a time; holds the scratch of one thread, reused between tiles.
template <typename T>
class PairKernel {
 public:
  PairKernel();
  ~PairKernel();
  // Adds the pair's cost and, with `derivatives`, slope, curvature and share of the tile's pixels
  // to `fields`, and sets those of the pair where it is not null. Returns the number of windows that counted
  // (centres in the tile).
  int64_t AddTile(const PairInput<T>& input, const Tile& tile, bool derivatives,
                  PixelFields<T>* fields, PairFields<T>* pair = nullptr);

 private:
  std::unique_ptr<KernelRows<T>> rows_;
};

// The instruction set that the kernels run with on this machine, "AVX2" for one. Results are the same
// bytes on machines where it is the same.
std::string KernelInstructionSet();

extern template class PairKernel<float>;
extern template class PairKernel<double>;
extern template struct PixelFields<float>;
extern template struct PixelFields<double>;

}  // namespace burin
