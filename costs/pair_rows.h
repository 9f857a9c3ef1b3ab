// The photometric energy as residuals where cameras move: for the minimisers of Ceres.
//
// No residuals of a facet's or vertex' own have its curvature with all cameras that see it and are small too. So
// the energy is cut by pairs of views. Of pair p and vertex v, with the sums over the pair's pixels of
// costs/camera_sums.h:
//
//   g_pv   gradient by the vertex
//   C_pv   curvature between the vertex and both cameras
//   B_pv   a curvature of the vertex so large that no other vertex' is needed: the rows' absolute sums on the diagonal
//
//   r_pv = L^-1 g_pv,   J_pv = [ L^T | L^-1 C_pv ],   B_pv = L L^T              vertex, first camera, second camera
//   r_p  = M^-1 g'_p,   J_p  = M^T,                   K'_p = M M^T              first camera, second camera
//
// with what the vertices leave of the pair's gradient and curvature by its cameras:
//
//   g'_p = g_p - sum_v C_pv^T B_pv^-1 g_pv,   K'_p = K_p - sum_v C_pv^T B_pv^-1 C_pv
//
// K'_p is positive semi-definite, as [ B C ; C^T K ] >= [ A C ; C^T K ] is. All together, J^T r is the gradient, and J^T J
// is the curvature with B = sum_p B_pv in A's place: larger (a step is shorter where neighbours that
// move alike would weigh less), with cameras and what couples them to the surface exact. A residual for each pair has
// what 1/2 |r|^2 lacks of the energy. (1/2 sum_pv |r|^2 is at most the energy as these are curvatures of windows' own
// residuals, up to rounding: what is more is divided out of r and multiplied into J.)
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/camera_pose.h"
#include "costs/camera_sums.h"

namespace burin {

class PairRows {
 public:
  static constexpr int kCameras = 12;  // unknowns of a pair's cameras
  using Row = Eigen::Matrix<double, kCameras, 1>;
  using MotionOfPose = Eigen::Matrix<double, 6, CameraPose::kSize>;

  // `sums` has its pattern.
  PairRows(const RoundContext& context, const PairSample& sample, const CameraSums& sums);

  int rows() const { return rows_; }  // unknowns of a vertex
  // Of each pair, ascending.
  const Adjacency& vertices() const { return vertices_; }

  // Before the sums of an evaluation, which are added a pair and vertex at a time; its pixels' facets have
  // weights B = sum_f weight n n^T, or sum_f weight (n.N)^2.
  void Clear();
  struct VertexSums {
    Eigen::Matrix3d curvature = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    Eigen::Matrix<double, kCameras, 3> coupling = Eigen::Matrix<double, kCameras, 3>::Zero();
  };  // of which the first rows() matter
  void Add(int pair, int vertex, const VertexSums& sums);

  // Makes the residuals of what was added. `energy`: of all pairs, at `poses`.
  void Factor(const CameraSums& sums, double energy, const std::vector<CameraPose>& poses);
  // The residuals of a vertex in a pair, at `place` of vertices().index, and of a pair. Their Jacobians where these are
  // not null, row-major: by the vertex' unknowns, and by the seven numbers of each camera.
  void OfVertex(int pair, int place, double* residuals, double* by_unknowns, double* by_first,
                double* by_second) const;
  void OfPair(int pair, double* residuals, double* by_first, double* by_second) const;
  static constexpr int kPairResiduals = kCameras + 1;

 private:
  struct Pair {
    int first = 0;
    int second = 0;
    Row residuals = Row::Zero();
    Eigen::Matrix<double, kCameras, kCameras> jacobian;  // by the motions
  };
  // Of a place: B or L, g or r, C or L^-1 C, one after the other.
  int Stride() const { return rows_ * (rows_ + 1 + kCameras); }
  double* At(int place) { return &values_[static_cast<size_t>(place) * Stride()]; }
  const double* At(int place) const { return &values_[static_cast<size_t>(place) * Stride()]; }
  // Returns the sum of squares of the pair's residuals.
  double FactorPair(const CameraSums::Pair& sums, int pair);

  int rows_;
  Adjacency vertices_;
  std::vector<Pair> pairs_;
  std::vector<double> values_;
  std::vector<MotionOfPose> motions_;  // of each view
  double beta_ = 1;
  double rest_ = 0;  // of the energy, for each pair: as a residual
};

}  // namespace burin
