// The part of the normal equations that cameras add, as a border of the matrix of the other unknowns:
//
//   H = [ A    C ]   A: SymmetricMatrix of the vertices (and what else terms solve for)
//       [ C^T  K ]   K: dense, six unknowns a camera
//
// A vertex knows the cameras that look at it and a camera up to all vertices: rows for cameras in A would be full, and
// an elimination of vertices fills K anyway. C is kept as its blocks that are not zero (core/solve/camera_coupling.h).
//
// Systems with H are solved by conjugate gradients. The preconditioner eliminates the surface exactly for a surface
// without neighbours: with B block diagonal, A <= B,
//
//   M = [ B    C ],   S = K - C^T B^-1 C  (Schur complement, dense, factored)
//       [ C^T  K ]
//
// M >= H is positive definite where H and the damping are. Only so do cameras get a step along the flat valleys in which
// surface and cameras move together.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <vector>

#include "core/scene/camera_pose.h"
#include "core/solve/camera_coupling.h"
#include "core/solve/conjugate_gradients.h"
#include "core/solve/symmetric_matrix.h"

namespace burin {

// Of each unknown of each camera, given what its diagonal has, the median over the cameras of its like: units in which
// cameras are alike whatever their pixels. The three of a centre have one: their axes are the world's. A camera that
// moves in another number of unknowns keeps its own.
std::vector<Eigen::VectorXd> MedianDiagonals(std::vector<Eigen::VectorXd> diagonals);

class CameraBorder {
 public:
  struct Column {
    int camera = 0;  // its number
    const CameraPose* pose = nullptr;
    int first = 0;  // unknown of the border
    int unknowns = 0;
  };

  // Cameras that move, `first_row` the first row of A of every vertex, -1 of those that do not move.
  void Begin(const std::vector<Column>& columns, int camera_count, std::vector<int> first_row);
  bool empty() const { return columns_.empty(); }
  int unknowns() const { return static_cast<int>(curvature_.rows()); }
  const std::vector<Column>& columns() const { return columns_; }

  // MedianDiagonals of K.
  Eigen::VectorXd MedianDiagonal() const;

  // K, to be added to.
  Eigen::MatrixXd& curvature() { return curvature_; }
  const Eigen::MatrixXd& curvature() const { return curvature_; }
  // C at the current poses, null = 0; plus[k] is how column k's pose moves with its unknowns (7 x unknowns, row-major).
  // `coupling` is kept.
  void SetCoupling(const CameraCoupling* coupling, const std::vector<const double*>& plus);

  // visit(row, unknown, block): the blocks of C that are not zero, each at its first row of A and unknown of the border, by
  // vertices and then by cameras.
  template <typename Visit>
  void ForCoupling(const Visit& visit) const {
    if (coupling_ == nullptr) return;
    ForPlaces(0, static_cast<int>(first_row_.size()), [&](int row, int column, int place) {
      visit(row, columns_[column].first,
            Eigen::MatrixXd(coupling_->Block(place) * motions_[column]));
    });
  }

  // y = H x of the rows of A followed by the border's; y has A's rows done already.
  void Multiply(const Eigen::VectorXd& x, Eigen::VectorXd* y) const;
  // C^T x of a vector of A's rows.
  Eigen::VectorXd TransposedTimes(const Eigen::VectorXd& x) const;
  // x += C z
  void AddTimes(const Eigen::VectorXd& z, Eigen::VectorXd* x) const;

  // Factors S with `damping` of the border's unknowns on K's diagonal. `inverse` has B^-1 by the blocks of A, one a vertex
  // that moves, first. False when S is not positive definite.
  bool Factor(const BlockJacobi& inverse, const Eigen::VectorXd& damping);
  // z = M^-1 r
  void ApplyInverse(const BlockJacobi& inverse, const Eigen::VectorXd& r, Eigen::VectorXd* z) const;

 private:
  using Motions = Eigen::Matrix<double, CameraCoupling::kMotion, Eigen::Dynamic>;
  // visit(first row of A, column, place of the coupling): the blocks of the vertices [begin, end) that move with cameras
  // that move, in their order.
  template <typename Visit>
  void ForPlaces(int begin, int end, const Visit& visit) const {
    const Adjacency& cameras = coupling_->cameras;
    for (int v = begin; v < end; ++v) {
      if (first_row_[v] < 0) continue;
      for (int place = cameras.start[v]; place < cameras.start[v + 1]; ++place) {
        const int column = column_of_[cameras.index[place]];
        if (column >= 0) visit(first_row_[v], column, place);
      }
    }
  }
  // Vertices of each camera, in their order.
  void ListVertices();
  // The border's unknowns as motions of all cameras, and back.
  Eigen::VectorXd ToMotions(const Eigen::VectorXd& z) const;
  Eigen::VectorXd FromMotions(const Eigen::VectorXd& motions) const;

  std::vector<Column> columns_;
  std::vector<int> column_of_;  // of each camera, -1 where it does not move
  std::vector<int> first_row_;
  Eigen::MatrixXd curvature_;
  std::vector<Motions> motions_;  // of each column
  const CameraCoupling* coupling_ = nullptr;
  Adjacency vertices_;  // of each column
  Eigen::LLT<Eigen::MatrixXd> schur_;
};

}  // namespace burin
