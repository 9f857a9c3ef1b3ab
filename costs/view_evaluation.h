// Evaluates the pairs of one reference view. The pair kernel works on the pixels; then the pixels of
// every facet corner are added into the sums that costs/photometric_round.h defines.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/scene/camera.h"
#include "core/solve/energy_term.h"
#include "costs/camera_sums.h"
#include "costs/corner_sums.h"
#include "costs/frozen_windows.h"
#include "costs/photometric_options.h"

namespace burin {

// Sums over the windows centred in one facet, of all pairs.
struct FacetScore {
  double cost = 0;    // sum of omega (1 - z)
  double weight = 0;  // sum of omega
};

// The same of a square of kCellPx x kCellPx pixels of a reference view.
constexpr int kCellPx = 4;
struct CellScore {
  int view = 0;
  uint32_t cell = 0;  // row-major
  float cost = 0;
  float weight = 0;  // above 0
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
  // Where the energy is evaluated.
  struct Point {
    const std::vector<Eigen::Vector3d>* positions = nullptr;
    const std::vector<Camera>* cameras = nullptr;  // of all views
  };
  struct Output {
    CornerSumsList sums;                            // of corner c of facet f at 3 f + c
    std::vector<FacetScore>* scores = nullptr;      // per facet; null = not wanted
    std::vector<CellScore>* cell_scores = nullptr;  // likewise; appended, ascending by cell
    CameraSums* cameras = nullptr;                  // null = not wanted; else with derivatives
    PairRows* pair_rows = nullptr;                  // likewise, beside these
    int64_t windows = 0;                            // that counted
  };

  virtual ~ViewEvaluation() = default;
  // The views of a level, with their images; they outlive its evaluations.
  virtual void BeginLevel(const std::vector<LevelView>& views) = 0;
  // Adds the view's pairs at `point` to `output`; slopes and curvatures with `derivatives`.
  virtual void Add(const Input& input, int view, const Point& point, bool derivatives,
                   Output* output) = 0;

  // Fields in double or single precision, as the options say. `options` is kept.
  static std::unique_ptr<ViewEvaluation> Make(const PhotometricOptions& options);
};

}  // namespace burin
