// The energy of one frozen round as a function of a vector, for other optimisers: E(x), its gradient and
// its Gauss-Newton matrix. burin's own strategies can solve it too.
//
// The mesh, its visibility, masks and pairs are frozen at the positions that the object is made with.
// Unknowns are the moves of the vertices that some pair sees and that have a normal, in ascending order
// of vertex: one per vertex along the normal, or three with motion.type = free. Their unit is the
// footprint of a full-resolution pixel, as in core/refine/refinement.h's normalised world. x = 0 is the
// mesh as given. Facets are not split.
//
// With cameras as unknowns, those of each view that some pair has follow, ascending: a rotation vector w in the camera's
// frame, radians, and a move dc of the centre in footprints along the world's axes, R = Exp(w) R_0 and c = c_0 + dc with
// X_cam = R (X - c).
#pragma once

#include <Eigen/Core>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "apps/run/pipeline.h"
#include "core/mesh/mesh.h"
#include "core/scene/pairs.h"
#include "core/scene/scene.h"
#include "core/solve/symmetric_matrix.h"

namespace burin {

// Calls from several threads wait for each other.
class LevelEnergy {
 public:
  // At pyramid level `level` (0 = full resolution) of the scene's photographs. Throws InputError for
  // options that do not fit, a level whose photographs are smaller than the window, pairs that name no
  // view, a view twice or that repeat, and when the pairs see nothing of the mesh.
  LevelEnergy(const Scene& scene, const TriangleMesh& mesh, const std::vector<CameraPair>& pairs,
              const PipelineOptions& options, int level, bool cameras = false);
  ~LevelEnergy();
  LevelEnergy(const LevelEnergy&) = delete;
  LevelEnergy& operator=(const LevelEnergy&) = delete;

  int unknowns() const;
  double footprint() const;  // world units of 1 in x
  // By unknown, its vertex and its camera; -1 where it is of none.
  const std::vector<int>& vertex_of_unknown() const;
  const std::vector<int>& camera_of_unknown() const;
  const std::vector<Eigen::Vector3d>& normals() const;  // unit, by vertex; 0 where there is none

  // x has unknowns() entries. Not finite where a cost function fails.
  double Evaluate(const Eigen::VectorXd& x, Eigen::VectorXd* gradient);
  // The same with the Gauss-Newton matrix.
  SymmetricMatrix Linearize(const Eigen::VectorXd& x, double* energy, Eigen::VectorXd* gradient);
  nlohmann::json Terms(const Eigen::VectorXd& x);  // energy by term, and "total"
  std::vector<Eigen::Vector3d> VerticesAt(const Eigen::VectorXd& x) const;  // in the scene's world
  std::vector<Camera> CamerasAt(const Eigen::VectorXd& x) const;  // likewise, of all views

  // From x = 0 with the strategy of that name and the options' solver.*; where it ended.
  struct Solution {
    Eigen::VectorXd x;
    double energy = 0;
    int iterations = 0;
    int64_t evaluations = 0;
    std::string termination;
  };
  Solution Solve(const std::string& strategy);

  // Taps that the window of each pixel of view `view` keeps, CV_32SC1; 0 where no facet is seen.
  cv::Mat1i KeptTaps(int view);

 private:
  struct Impl;
  class InUse;
  std::unique_ptr<Impl> impl_;
};

}  // namespace burin
