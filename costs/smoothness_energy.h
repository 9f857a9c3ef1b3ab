// The smoothness energy: Laplacian residuals of costs/stencil_cost.h on every vertex.
//
//   E_smooth = weight / 2 * sum_v | L V |_v^2 / h_v^2,      h_v = mean edge length at v, frozen
//
// For the umbrella, |L V| is close to h^2/4 |Laplace(u)|. So the sum is 1.1 to 1.5 times weight/32 times the
// integral of |Laplace(u)|^2 over the surface: it has no unit and hardly depends on how the mesh is cut, finely or
// coarsely, evenly or adapted. (For the bi-Laplacian it does depend on that.)
//
// A vertex that keeps its shape (RoundContext::keeps_shape: the round has no evidence for it, or it is on a
// part thinner than a window) has as target L V at the start of the round, where it is free that of the level. So it follows its surroundings and
// neither shrinks nor flattens.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/solve/energy_term.h"
#include "core/support/options.h"

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
  std::unique_ptr<TermRound> Freeze(const RoundContext& context) override;

 private:
  const SmoothnessOptions options_;
};

}  // namespace burin
