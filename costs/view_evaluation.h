// Evaluates the pairs of one reference view. The pair kernel works on the pixels; then the pixels of
// every facet corner are added into the sums that costs/photometric_round.h defines.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/solve/energy_term.h"
#include "costs/frozen_windows.h"
#include "costs/photometric_options.h"

namespace burin {

// Sums over the pixels of one corner of one facet (costs/photometric_energy.h).
struct CornerSums {
  double cost = 0;  // of the windows centred there
  double share =
      0;  // of the cost of all windows that have a tap there: a window gives each tap cost / n
  double slope[3] = {0, 0, 0};
  double curvature[6] = {0, 0, 0, 0, 0, 0};  // (0,0) (0,1) (0,2) (1,1) (1,2) (2,2)

  // Where (k, l) and (l, k) are in `curvature`.
  static constexpr int Packed(int k, int l) {
    constexpr int kPacked[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    return kPacked[k][l];
  }
};

// Sums over the windows centred in one facet, of all pairs.
struct FacetScore {
  double cost = 0;    // sum of omega (1 - z)
  double weight = 0;  // sum of omega
};

class ViewEvaluation {
 public:
  // The frozen state of a round.
  struct Input {
    const RoundContext* context = nullptr;
    const FrozenWindows* windows = nullptr;
    const PairSample* sample = nullptr;  // of the round
    bool squares_only = false;           // scores of the windows of HeldBackSquares alone
  };
  struct Output {
    std::vector<CornerSums> sums;               // of corner c of facet f at 3 f + c
    std::vector<FacetScore>* scores = nullptr;  // per facet; null = not wanted
    int64_t windows = 0;                        // that counted
  };

  virtual ~ViewEvaluation() = default;
  // The views of a level, with their images; they outlive its evaluations.
  virtual void BeginLevel(const std::vector<LevelView>& views) = 0;
  // Adds the view's pairs at `positions` to `output`; slopes and curvatures with `derivatives`.
  virtual void Add(const Input& input, int view, const std::vector<Eigen::Vector3d>& positions,
                   bool derivatives, Output* output) = 0;

  // Fields in double or single precision, as the options say. `options` is kept.
  static std::unique_ptr<ViewEvaluation> Make(const PhotometricOptions& options);
};

}  // namespace burin
