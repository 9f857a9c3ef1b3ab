// Scores a mesh as the DTU multi-view benchmark does (Jensen et al., "Large scale multi-view
// stereopsis evaluation", 2014; Aanaes et al., "Large-scale data for multiple-view stereopsis",
// 2016). It takes distances between two sets of points of equal density, without the outliers, inside
// the volume where the truth was observed.
//
// Protocol
//  1. Points. M: the mesh sampled area-uniformly, four samples per square of edge `spacing`, then
//     thinned (core/mesh/point_thinning.h) so that no two are nearer than `spacing`. T: a truth cloud
//     thinned likewise; a truth mesh is sampled and thinned like the mesh.
//  2. Distances are from point to point: d(m) = min_{t in T} |m - t|, d(t) = min_{m in M} |t - m|.
//     With spacing h they cannot fall much below h/2, however good the mesh is.
//  3. Region. Accuracy is over the m inside the observability mask, completeness over the t above
//     the table plane. Neither takes points away from the set that the other is measured to.
//  4. Cap. Points with a distance beyond `cap` are left out of mean and median, and counted.
// Deviation: the benchmark thins the reconstruction only (its scans are published thinned). burin
// thins the truth too, which leaves those scans as they are but for rounding.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/evaluate/evaluation_region.h"
#include "core/evaluate/truth.h"
#include "core/mesh/mesh.h"
#include "core/support/distance_statistics.h"
#include "core/support/options.h"

namespace burin {

struct DtuOptions {
  bool run = false;
  double spacing = 0.2;  // in unit
  double cap = 20;       // in unit
  std::string mask;      // file of ReadVoxelMask; empty = everywhere
  std::string plane;     // file of ReadPlane; empty = everywhere

  void Describe(OptionSet* set);
};

// Where distances count; nothing set = everywhere.
struct DtuRegion {
  std::optional<VoxelMask> mask;         // for the accuracy
  std::optional<Eigen::Vector4d> plane;  // for the completeness
};

// Reads the files that the options name. Throws InputError, also when they name files without run.
DtuRegion ReadDtuRegion(const DtuOptions& options);

struct DtuEvaluation {
  double spacing = 0;               // world units
  double cap = 0;                   // world units
  std::int64_t mesh_points = 0;     // after thinning, before the mask
  std::int64_t truth_points = 0;    // after thinning, before the plane
  DistanceStatistics accuracy;      // count: in the mask; matched: within the cap
  DistanceStatistics completeness;  // count: above the plane; matched: within the cap
  // Mean of the two means, as tables of the benchmark often give it; nothing when either side has
  // no point within the cap.
  std::optional<double> Overall() const;
};

// Steps 2 to 4 for sets of points, `cap` in world units; leaves spacing 0. Throws InputError when
// the mask or the plane leaves no point.
DtuEvaluation CompareDtuPoints(const std::vector<Eigen::Vector3d>& mesh_points,
                               const std::vector<Eigen::Vector3d>& truth_points, double cap,
                               const DtuRegion& region = {});

// The protocol above; `mesh` in the frame of the truth, `unit` in world units. Throws InputError
// when there is nothing to measure or the spacing is too small for the size of the surfaces.
DtuEvaluation EvaluateDtu(const TriangleMesh& mesh, const Truth& truth, const DtuOptions& options,
                          const DtuRegion& region, double unit, int seed);

}  // namespace burin
