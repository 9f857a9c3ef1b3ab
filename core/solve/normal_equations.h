// The normal equations of a round's energy, assembled by burin itself on all threads.
//
//   E = sum_k E_k,   g = sum_k g_k,   H = sum_k H_k
//
// over every block k of the round's energy (core/solve/round_energy.h), in the unknowns of the moving parameter
// blocks: one with a LineAlongNormal has one unknown, one without manifold as many as coordinates, and a constant
// one none. Ceres holds the Jacobian of residuals instead (about 80 numbers a vertex against 19 of H for one unknown a
// vertex, twice in every product), and makes it on one thread when sums must have an order.
//
// Results are the same bytes for any number of threads. Blocks are evaluated in batches of fixed size; after each, every
// row of H and g that the batch touches adds the batch's blocks in their order. Which thread does a row does not
// matter. The pattern of H and the place in it of every entry of every block are made once, in the constructor.
//
// Cameras (RoundEnergy::IsCamera) are the last unknowns. They have no rows in matrix() but are its border
// (core/solve/camera_border.h).
//
// The values of moving parameter blocks are read and written in place, which Ceres' own minimisers
// do too when a problem has an evaluation callback.
#pragma once

#include <ceres/evaluation_callback.h>
#include <ceres/manifold.h>

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/solve/camera_border.h"
#include "core/solve/round_energy.h"
#include "core/solve/symmetric_matrix.h"

namespace burin {

class NormalEquations {
 public:
  // `callback` prepares the blocks for an evaluation, null if none. Unknowns are in the order of the parameters'
  // numbers, but those of cameras come last. The energy's blocks, constant parameters and manifolds must not change afterwards.
  NormalEquations(const RoundEnergy& energy, ceres::EvaluationCallback* callback);

  int unknowns() const { return unknowns_; }
  // Parameter blocks with unknowns, and the first unknown of each.
  struct MovingBlock {
    int parameter;  // its number in the RoundEnergy
    double* values;
    const ceres::Manifold* manifold;  // null when none
    int size;                         // coordinates
    int tangent_size;                 // unknowns
    int first_unknown;
    int first_value;  // in a State
  };
  const std::vector<MovingBlock>& moving_blocks() const { return blocks_; }

  // E at the current values. False when a cost function fails or E is not finite.
  bool EvaluateCost(double* cost);
  // E and g, or E, g and H, at the current values. At the point of the last EvaluateCost the
  // callback is told that the point is not new.
  bool EvaluateGradient(double* cost, Eigen::VectorXd* gradient);
  bool Evaluate(double* cost, Eigen::VectorXd* gradient);
  // H of the last Evaluate(), full rows, without the cameras; and what these add to it.
  const SymmetricMatrix& matrix() const { return matrix_; }
  const CameraBorder& border() const { return border_; }
  CameraBorder* mutable_border() { return &border_; }
  // y = (H + D) x with the cameras, D diagonal; `damping` may be empty for D = 0.
  void Multiply(const Eigen::VectorXd& x, const Eigen::VectorXd& damping, Eigen::VectorXd* y) const;
  // H with the cameras' rows and columns, in other unknowns x of these: those of the equations change by of_cameras[k] dx for
  // the k-th camera that moves.
  SymmetricMatrix WholeMatrix(const std::vector<Eigen::MatrixXd>& of_cameras) const;
  // H's whole diagonal.
  Eigen::VectorXd Diagonal() const;

  // Values of all moving blocks, one after the other.
  using State = std::vector<double>;
  void Save(State* state) const;
  void Restore(const State& state);
  // values = Plus(state, delta), block by block. `state` is not changed.
  // False when a manifold refuses.
  bool SetPlus(const State& state, const Eigen::VectorXd& delta);

 private:
  static constexpr int kBatch = 4096;  // blocks
  enum class Wanted { kCost, kGradient, kMatrix };
  // Blocks [begin, end) of one part of the energy; `first` is the number of the first among all.
  struct Batch {
    const EnergyBlocks* blocks;
    int begin;
    int end;
    int first;
    bool of_cameras;  // moving ones: the blocks are parts of the border
  };
  struct Part {
    int first;  // number of its first block among all
    int first_batch;
  };
  struct Place {
    int first_value;  // into the batch's buffer: m gradient entries, then the m x m matrix
    int unknowns;     // m
  };
  // One row block of H in one batch: the contributions [begin, end) are its blocks there.
  struct RowTask {
    int block;
    int begin;
    int end;
    int first_slot;
  };
  struct Contribution {
    int of;   // number of the block among all
    int row;  // first unknown of the row block among those of the block
  };

  void MakeUnknowns();
  void MakeBatches();
  void MakePattern();
  void MakeRows(const Adjacency& lower);
  void MakeSlots(const std::vector<int>& first, const Adjacency& lower);
  int BatchOf(int of) const;  // the number of its batch
  // Parameter blocks of block `of` of all, which is in `batch`.
  const int* ParametersBegin(const Batch& batch, int of) const {
    return batch.blocks->parameters().Begin(batch.begin + of - batch.first);
  }
  const int* ParametersEnd(const Batch& batch, int of) const {
    return batch.blocks->parameters().End(batch.begin + of - batch.first);
  }
  bool Run(Wanted wanted, double* cost, Eigen::VectorXd* gradient);
  bool EvaluateBlock(const Batch& batch, int k, Wanted wanted);
  void AddRows(const Batch& batch, const RowTask& task, Wanted wanted, Eigen::VectorXd* gradient);
  void CopyLowerToUpper();
  void AddToBorder(const Batch& batch, Wanted wanted, Eigen::VectorXd* gradient);
  void MakeBorder();
  void FinishBorder();
  // Of a parameter, the block that has rows in the matrix, or -1.
  int RowBlock(int parameter) const {
    return moving_of_[parameter] < row_blocks_ ? moving_of_[parameter] : -1;
  }

  const RoundEnergy& energy_;
  ceres::EvaluationCallback* callback_;
  bool point_is_new_ = true;
  int unknowns_ = 0;
  int row_blocks_ = 0;  // moving blocks before those of cameras
  int state_size_ = 0;
  std::vector<MovingBlock> blocks_;
  std::vector<int> block_of_unknown_;
  std::vector<int> moving_of_;  // of each parameter, into blocks_; -1 for a constant one
  std::vector<Part> parts_;     // of the energy
  std::vector<Batch> batches_;
  std::vector<Place> places_;           // of each block of the energy
  std::vector<double> costs_;           // of each block of the energy
  std::vector<int> first_plus_;         // of each moving block, into plus_jacobians_
  std::vector<double> plus_jacobians_;  // of all blocks, at the current values
  std::vector<Contribution> contributions_;
  std::vector<RowTask> row_tasks_;
  std::vector<int> first_task_;   // of each batch, and the end
  std::vector<uint16_t> slots_;   // offset in its rows of each lower entry of each contribution
  std::vector<int> first_upper_;  // of each moving block, and the end
  // Of every upper off-diagonal block of a row block, in the order of its columns: the offset in the rows of that
  // column's block of the lower block that it is the transpose of.
  std::vector<uint16_t> lower_of_upper_;
  std::vector<double> buffer_;  // one batch
  SymmetricMatrix matrix_;
  CameraBorder border_;
};

}  // namespace burin
