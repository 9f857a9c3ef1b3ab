// The discrete step before solving: which directed camera pairs enter the photometric energy.
//
// Methods:
//   vu             most common sparse points under a parallax of 20 to 60 degrees (Vu et al. 2012)
//   sparse_points  the same under 8 to 45 degrees
//   mesh_parallax  most shared visible surface under 8 to 45 degrees
#pragma once

#include <string>
#include <vector>

#include "core/mesh.h"
#include "core/options.h"
#include "core/pairs.h"
#include "core/scene.h"

namespace burin {

struct PairsOptions {
  std::string method = "auto";  // sparse_points when the scene has points, else mesh_parallax
  int per_camera = 4;
  double min_parallax_deg = -1;  // -1 = the method's own: vu 20, others 8
  double max_parallax_deg = -1;  // -1 = the method's own: vu 60, others 45
  void Describe(OptionSet* set);
};

struct PairSelection {
  std::string method;           // the one used
  double min_parallax_deg = 0;  // the range used
  double max_parallax_deg = 0;
  std::vector<CameraPair> pairs;
  std::vector<std::string> warnings;  // a line for each camera without a partner, with the reason
};

// Throws InputError when no camera gets a partner, saying for each camera which test failed.
PairSelection SelectPairs(const Scene& scene, const TriangleMesh& mesh,
                          const PairsOptions& options);

}  // namespace burin
