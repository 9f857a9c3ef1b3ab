// The discrete step before solving: which directed camera pairs enter the photometric energy.
#pragma once

#include <string>
#include <vector>

#include "core/mesh.h"
#include "core/options.h"
#include "core/pairs.h"
#include "core/scene.h"

namespace burin {

struct PairsOptions {
  std::string method = "auto";  // vu when the scene has points, else mesh_parallax
  int per_camera = 4;
  double min_parallax_deg = 20;
  double max_parallax_deg = 60;
  void Describe(OptionSet* set);
};

struct PairSelection {
  std::string method;  // the one used
  std::vector<CameraPair> pairs;
  std::vector<std::string> warnings;  // a line for each camera without a partner, with the reason
};

// Throws InputError when no camera gets a partner, saying for each camera which test failed.
PairSelection SelectPairs(const Scene& scene, const TriangleMesh& mesh,
                          const PairsOptions& options);

}  // namespace burin
