// The smoothness energy: Laplacian residuals of costs/stencil_cost.h on every vertex.
//
//   E_smooth = weight / 2 * sum_v | L V |_v^2 / h_v^2,      h_v = mean edge length at v, frozen
//
// |L V| is close to h^2/4 |Laplace(u)| for the umbrella, so that the sum is close to weight/32 times
// the integral of |Laplace(u)|^2 over the surface: it has no unit and hardly depends on how finely the
// mesh is cut (for the bi-Laplacian it does).
// A vertex that no pair has seen, in this round or an earlier one, keeps its shape instead (target L V
// at the start of the round): what nobody sees follows its surroundings and neither shrinks nor
// flattens. (What was seen and no longer is: core/refine/hidden_folds.h.)
#pragma once

#include <string>
#include <vector>

#include "core/solve/energy_term.h"
#include "core/support/options.h"
#include "costs/stencil_cost.h"

namespace burin {

enum class SmoothnessType { kUmbrella, kBilaplacian, kCotangent, kNone };
inline Choices<SmoothnessType> ChoicesOf(SmoothnessType) {
  return {{SmoothnessType::kUmbrella, "umbrella"},
          {SmoothnessType::kBilaplacian, "bilaplacian"},
          {SmoothnessType::kCotangent, "cotangent"},
          {SmoothnessType::kNone, "none"}};
}

struct SmoothnessOptions {
  SmoothnessType type = SmoothnessType::kUmbrella;
  double weight = 60;
  void Describe(OptionSet* set);
};

class SmoothnessEnergy : public EnergyTerm {
 public:
  explicit SmoothnessEnergy(const SmoothnessOptions& options) : options_(options) {}
  std::string Name() const override { return "smoothness"; }
  void BeginRound(const RoundContext& context) override { context_ = &context; }
  void AddResiduals(ceres::Problem* problem, std::vector<Eigen::Vector3d>* vertices) override;

 private:
  Stencil MakeStencil(int v) const;
  SmoothnessOptions options_;
  const RoundContext* context_ = nullptr;
};

}  // namespace burin
