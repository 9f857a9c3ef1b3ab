// The normal equations of a round's ceres::Problem, assembled by burin itself on all threads.
//
//   E = 1/2 sum_b |r_b|^2,   g = J^T r,   H = J^T J
//
// over every residual block b of the problem, whoever added it, in the unknowns of the moving
// parameter blocks: J_b is the cost function's Jacobian times the manifold's Plus Jacobian, so that
// a block with a LineAlongNormal has one unknown, one without manifold as many as coordinates, and
// a constant one none. Ceres holds J instead (about 80 numbers a vertex against 19 of H for one
// unknown a vertex, twice in every product), and makes it on one thread when sums must have an
// order.
//
// Results are the same bytes for any number of threads. Residual blocks are evaluated in batches of
// fixed size; after each, every row of H and g that the batch touches adds the batch's blocks in
// their order in the problem. Which thread does a row does not matter. The pattern of H and the
// place in it of every entry of every block are made once, in the constructor.
//
// Of a TangentCost (core/solve/tangent_cost.h) it takes J^T r and J^T J as they are.
//
// The values of moving parameter blocks are read and written in place, which Ceres' own minimisers
// do too when a problem has an evaluation callback.
#pragma once

#include <ceres/cost_function.h>
#include <ceres/evaluation_callback.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/solve/symmetric_matrix.h"
#include "core/solve/tangent_cost.h"

namespace burin {

class NormalEquations {
 public:
  // `callback` is the one the problem was made with, null if none. Unknowns are those of
  // `order` (parameter blocks, each once) that are not constant, then those of the problem's other
  // blocks in the order in which residual blocks first name them. Loss functions and bounds are not
  // supported (CHECK). The problem must not change afterwards.
  NormalEquations(ceres::Problem* problem, ceres::EvaluationCallback* callback,
                  const std::vector<double*>& order);

  int unknowns() const { return unknowns_; }
  // Parameter blocks with unknowns, and the first unknown of each.
  struct MovingBlock {
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
  // H of the last Evaluate(), full rows.
  const SymmetricMatrix& matrix() const { return matrix_; }

  // Values of all moving blocks, one after the other.
  using State = std::vector<double>;
  void Save(State* state) const;
  void Restore(const State& state);
  // values = Plus(state, delta), block by block. `state` is not changed.
  // False when a manifold refuses.
  bool SetPlus(const State& state, const Eigen::VectorXd& delta);

 private:
  static constexpr int kBatch = 4096;  // residual blocks
  enum class Wanted { kCost, kGradient, kMatrix };
  struct Residuals {
    const ceres::CostFunction* cost_function;
    const TangentCost* tangent;  // the same, or null
    int first_parameter;         // into parameters_, blocks as the cost function takes them
    int first_value;  // into the batch's buffer: m gradient entries, then the m x m matrix
    int unknowns;     // m
  };
  struct Parameter {
    double* values;
    int block;  // index into blocks_, -1 for a constant one
  };
  // One row block of H in one batch: the contributions [begin, end) are its residual blocks there.
  struct RowTask {
    int block;
    int begin;
    int end;
    int64_t first_slot;
  };
  // Upper off-diagonal block of a row block: the transpose of one of `block`'s lower ones.
  struct Mirror {
    int block;
    int lower;  // offset in the rows of `block`
    int upper;  // offset in the row block's own rows
  };
  struct Contribution {
    int residuals;  // index into residuals_
    int row;        // first unknown of the row block among those of the residual block
  };

  void MakeUnknowns(const std::vector<ceres::ResidualBlockId>& ids,
                    const std::vector<double*>& order, ceres::Problem* problem);
  int ParameterEnd(int residuals) const;
  void MakePattern();
  void MakeRows(const Adjacency& lower);
  void MakeSlots(const std::vector<int>& first, const Adjacency& lower);
  bool Run(Wanted wanted, double* cost, Eigen::VectorXd* gradient);
  bool EvaluateResiduals(int index, Wanted wanted);
  bool EvaluateTangent(int index, Wanted wanted);
  void AddRows(const RowTask& task, Wanted wanted, Eigen::VectorXd* gradient);
  void CopyLowerToUpper();

  ceres::EvaluationCallback* callback_;
  bool point_is_new_ = true;
  int unknowns_ = 0;
  int state_size_ = 0;
  std::vector<MovingBlock> blocks_;
  std::vector<Residuals> residuals_;
  std::vector<Parameter> parameters_;
  std::vector<int> first_plus_;         // of each moving block, into plus_jacobians_
  std::vector<double> plus_jacobians_;  // of all blocks, at the current values
  std::vector<double> costs_;           // of each residual block
  std::vector<Contribution> contributions_;
  std::vector<RowTask> row_tasks_;
  std::vector<int> first_task_;    // of each batch, and the end
  std::vector<int> slots_;         // offset in its rows of each lower entry of each contribution
  std::vector<int> first_mirror_;  // of each moving block, and the end
  std::vector<Mirror> mirrors_;
  std::vector<double> buffer_;  // one batch
  SymmetricMatrix matrix_;
};

}  // namespace burin
