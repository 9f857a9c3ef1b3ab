// The silhouette term: the contour of the surface on the outlines of the object's masks (costs/silhouette_view.h), in
// all views that have one (LevelView::object). What thin parts and rims have no correlation window for, outlines show.
//
//   E_silhouette = weight sum_views E_view + membrane/2 sum_(a,b) |d_a - d_b|^2
//
// the second over the edges of vertices that are free (RoundContext::free), d since the level began in its pixels
// (costs/membrane_blocks.h). Contours are frozen in a round, and so is the camera of each view. Parts less than three
// pixels of a level across take part on the finest only: on coarser ones their outline is not resolved.
#pragma once

#include <memory>
#include <string>

#include "core/solve/energy_term.h"
#include "costs/silhouette_options.h"

namespace burin {

class SilhouetteEnergy : public EnergyTerm {
 public:
  explicit SilhouetteEnergy(const SilhouetteTermOptions& options) : options_(options) {}
  std::string Name() const override { return "silhouette"; }
  std::unique_ptr<TermRound> Freeze(const RoundContext& context) override;

 private:
  const SilhouetteTermOptions options_;
};

}  // namespace burin
