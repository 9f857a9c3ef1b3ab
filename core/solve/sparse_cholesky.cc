#include "core/solve/sparse_cholesky.h"

#include <cholmod.h>
#include <glog/logging.h>

#include <algorithm>
#include <vector>

namespace burin {

struct SparseCholesky::State {
  State() {
    cholmod_start(&common);
    common.print = 0;
    // Full L L^T in either kind of factor, so that L and L^T can be solved with apart.
    common.final_ll = 1;
  }
  ~State() {
    cholmod_free_factor(&factor, &common);
    cholmod_free_dense(&x, &common);
    cholmod_free_dense(&y, &common);
    cholmod_free_dense(&e, &common);
    cholmod_finish(&common);
  }

  void Solve(int first, int second, const Eigen::VectorXd& b, Eigen::VectorXd* result) {
    result->resize(b.size());
    Apply(first, b.data(), result->data(), b.size());
    Apply(second, result->data(), result->data(), b.size());
  }

  void Apply(int system, const double* b, double* result, Eigen::Index size) {
    cholmod_dense right = {};
    right.nrow = right.d = right.nzmax = size;
    right.ncol = 1;
    right.x = const_cast<double*>(b);
    right.xtype = CHOLMOD_REAL;
    right.dtype = CHOLMOD_DOUBLE;
    CHECK(cholmod_solve2(system, factor, &right, nullptr, &x, nullptr, &y, &e, &common))
        << "CHOLMOD status " << common.status;
    std::copy_n(static_cast<const double*>(x->x), size, result);
  }

  cholmod_common common;
  cholmod_factor* factor = nullptr;
  // Work space of cholmod_solve2.
  cholmod_dense* x = nullptr;
  cholmod_dense* y = nullptr;
  cholmod_dense* e = nullptr;
};

SparseCholesky::SparseCholesky() : state_(std::make_unique<State>()) {}
SparseCholesky::~SparseCholesky() = default;

bool SparseCholesky::Factor(const SymmetricMatrix& matrix, const Eigen::VectorXd& damping) {
  // The lower triangle by rows is the upper one by columns.
  std::vector<int> start(1, 0);
  std::vector<int> row;
  std::vector<double> value;
  row.reserve(matrix.column.size() / 2 + matrix.size);
  value.reserve(row.capacity());
  for (int i = 0; i < matrix.size; ++i) {
    for (int64_t k = matrix.start[i]; k < matrix.start[i + 1]; ++k) {
      if (matrix.column[k] > i) continue;
      row.push_back(matrix.column[k]);
      value.push_back(matrix.value[k] + (k == matrix.diagonal[i] ? damping[i] : 0.0));
    }
    start.push_back(static_cast<int>(row.size()));
  }
  cholmod_sparse upper = {};
  upper.nrow = upper.ncol = matrix.size;
  upper.nzmax = row.size();
  upper.p = start.data();
  upper.i = row.data();
  upper.x = value.data();
  upper.stype = 1;
  upper.itype = CHOLMOD_INT;
  upper.xtype = CHOLMOD_REAL;
  upper.dtype = CHOLMOD_DOUBLE;
  upper.sorted = 1;
  upper.packed = 1;
  if (state_->factor == nullptr) state_->factor = cholmod_analyze(&upper, &state_->common);
  if (state_->factor == nullptr) return false;
  return cholmod_factorize(&upper, state_->factor, &state_->common) != 0 &&
         state_->common.status == CHOLMOD_OK;
}

void SparseCholesky::ApplyInverseLower(const Eigen::VectorXd& b, Eigen::VectorXd* x) {
  state_->Solve(CHOLMOD_P, CHOLMOD_L, b, x);
}

void SparseCholesky::ApplyInverseUpper(const Eigen::VectorXd& b, Eigen::VectorXd* x) {
  state_->Solve(CHOLMOD_Lt, CHOLMOD_Pt, b, x);
}

double SparseCholesky::fill() const { return state_->common.lnz; }

}  // namespace burin
