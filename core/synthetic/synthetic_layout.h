// Where things stand in a synthetic scene: surfaces and cameras, before anything is rendered.
#pragma once

#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/camera.h"
#include "core/synthetic/synthetic.h"

namespace burin {

struct SyntheticLayout {
  TriangleMesh truth;
  TriangleMesh init;  // without the noise of SyntheticOptions::init_noise_px
  std::vector<Camera> cameras;
  double footprint = 0;         // world units per px at the scene's centre
  double background = 25;       // grey level where there is no surface
  double init_noise_share = 1;  // of init_noise_px that the initial mesh takes
};

// Options as SyntheticOptions documents them, in range; `views` of 0 gives the scene's own number.
SyntheticLayout ReliefLayout(const SyntheticOptions& options);
SyntheticLayout OccludersLayout(const SyntheticOptions& options);
SyntheticLayout RodsLayout(const SyntheticOptions& options);
SyntheticLayout PlatesLayout(const SyntheticOptions& options);
SyntheticLayout MembraneLayout(const SyntheticOptions& options);
SyntheticLayout SkyLayout(const SyntheticOptions& options);
SyntheticLayout BoulderLayout(const SyntheticOptions& options);
// Throws InputError when the scan has no faces or no extent.
SyntheticLayout ScanLayout(const SyntheticOptions& options, const TriangleMesh& scan);

}  // namespace burin
