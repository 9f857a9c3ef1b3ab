// Whether a level of the refinement improved the mesh, judged by data it did not see: camera pairs
// that were not used, or else small squares of the images that were left out.
//
// Both meshes have the same facets. On the windows that fall into a facet, of both meshes'
// own visibility V in {before, after},
//
//   e(mesh) = sum_V sum omega (1 - z) / sum_V sum omega
//
// so that both are scored on the same pixels; facets that one of them leaves without windows do not
// count. The change is the mean of e(after) - e(before) over facets, weighted by the smaller sum
// of omega; its standard error comes from the spread over batches of neighbouring facets.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "core/energy_term.h"
#include "core/pairs.h"
#include "costs/photometric_energy.h"

namespace burin {

struct HeldBackVerdict {
  double before = 0;  // weighted mean of 1 - z
  double after = 0;
  double standard_error = 0;  // of after - before
  double windows = 0;         // sum of the weights
};

// `pairs` held back; where there are none, the squares of PhotometricEnergy::HoldBackSquares() in
// `used_pairs`. The term's BeginLevel() has been called with `views`; its round is ended.
HeldBackVerdict CompareOnHeldBack(const std::vector<LevelView>& views,
                                  const std::vector<CameraPair>& pairs,
                                  const std::vector<CameraPair>& used_pairs, double border_px,
                                  const TriangleMesh& before, const TriangleMesh& after,
                                  PhotometricEnergy* photometric);

}  // namespace burin
