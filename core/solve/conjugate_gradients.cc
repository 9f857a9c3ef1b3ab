#include "core/solve/conjugate_gradients.h"

#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kBlockGrain = 4096;

}  // namespace

void BlockJacobi::Factor(const SymmetricMatrix& matrix, const Eigen::VectorXd& damping,
                         const std::vector<int>& first) {
  first_ = first;
  const int count = static_cast<int>(first_.size()) - 1;
  start_.assign(1, 0);
  for (int k = 0; k < count; ++k) {
    const int64_t n = first_[k + 1] - first_[k];
    start_.push_back(start_.back() + n * n);
  }
  inverse_.resize(start_.back());
  ParallelFor(count, kBlockGrain, [&](int begin, int end) {
    Eigen::MatrixXd block;
    for (int k = begin; k < end; ++k) {
      const int n = first_[k + 1] - first_[k];
      double* inverse = &inverse_[start_[k]];
      if (n == 1) {
        inverse[0] = 1 / (matrix.value[matrix.diagonal[first_[k]]] + damping[first_[k]]);
        continue;
      }
      // The entries of a block are consecutive in its rows, around the diagonal.
      block.resize(n, n);
      for (int i = 0; i < n; ++i) {
        const int64_t row = matrix.diagonal[first_[k] + i] - i;
        for (int j = 0; j < n; ++j) block(i, j) = matrix.value[row + j];
        block(i, i) += damping[first_[k] + i];
      }
      const Eigen::LLT<Eigen::MatrixXd> factor(block);
      Eigen::Map<Eigen::MatrixXd> result(inverse, n, n);
      if (factor.info() == Eigen::Success) {
        result = factor.solve(Eigen::MatrixXd::Identity(n, n));
      } else {
        result = block.diagonal().cwiseInverse().asDiagonal();
      }
    }
  });
}

void BlockJacobi::Apply(const Eigen::VectorXd& r, Eigen::VectorXd* z) const {
  z->resize(r.size());
  ParallelFor(static_cast<int>(first_.size()) - 1, kBlockGrain, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      const int n = first_[k + 1] - first_[k];
      const double* inverse = &inverse_[start_[k]];
      for (int i = 0; i < n; ++i) {
        double sum = 0;
        for (int j = 0; j < n; ++j) sum += inverse[i * n + j] * r[first_[k] + j];
        (*z)[first_[k] + i] = sum;
      }
    }
  });
}

void BlockJacobi::FactorMajorant(const SymmetricMatrix& matrix, const Eigen::VectorXd& damping,
                                 const std::vector<int>& first) {
  Eigen::VectorXd more = damping;
  ParallelFor(static_cast<int>(first.size()) - 1, kBlockGrain, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      for (int row = first[k]; row < first[k + 1]; ++row) {
        for (int64_t e = matrix.start[row]; e < matrix.start[row + 1]; ++e) {
          const int column = matrix.column[e];
          if (column < first[k] || column >= first[k + 1]) more[row] += std::abs(matrix.value[e]);
        }
      }
    }
  });
  Factor(matrix, more, first);
}

Eigen::Map<const Eigen::MatrixXd> BlockJacobi::OfUnknown(int unknown, int unknowns) const {
  const auto block = std::lower_bound(first_.begin(), first_.end(), unknown) - first_.begin();
  DCHECK(first_[block] == unknown && first_[block + 1] == unknown + unknowns);
  return {&inverse_[start_[block]], unknowns, unknowns};
}

int ConjugateGradients(const SymmetricMatrix& matrix, const Eigen::VectorXd& damping,
                       const BlockJacobi& preconditioner, const Eigen::VectorXd& b,
                       const ConjugateGradientOptions& options, Eigen::VectorXd* x) {
  return ConjugateGradients(
      [&](const Eigen::VectorXd& p, Eigen::VectorXd* product) {
        matrix.Multiply(p, damping, product);
      },
      [&](const Eigen::VectorXd& r, Eigen::VectorXd* z) { preconditioner.Apply(r, z); }, b, options,
      x);
}

int ConjugateGradients(const LinearMap& multiply, const LinearMap& precondition,
                       const Eigen::VectorXd& b, const ConjugateGradientOptions& options,
                       Eigen::VectorXd* x) {
  const auto n = static_cast<int>(b.size());
  x->setZero(n);
  Eigen::VectorXd r = b;
  Eigen::VectorXd z;
  Eigen::VectorXd product;
  precondition(r, &z);
  Eigen::VectorXd p = z;
  double rz = Dot(r, z);
  double q_before = 0;
  int iteration = 0;
  while (iteration < options.max_iterations && rz > 0) {
    multiply(p, &product);
    const double curvature = Dot(p, product);
    if (!(curvature > 0)) break;
    const double alpha = rz / curvature;
    // Q(x) = -1/2 x^T (b + r)
    const double q = -0.5 * ChunkedSum(n, [&](int begin, int end) {
      const int count = end - begin;
      x->segment(begin, count) += alpha * p.segment(begin, count);
      r.segment(begin, count) -= alpha * product.segment(begin, count);
      return x->segment(begin, count).dot(b.segment(begin, count) + r.segment(begin, count));
    });
    ++iteration;
    if (iteration * (q - q_before) / q < options.tolerance) break;
    q_before = q;
    precondition(r, &z);
    const double rz_next = Dot(r, z);
    const double beta = rz_next / rz;
    rz = rz_next;
    ForChunks(n, [&](int begin, int end) {
      const int count = end - begin;
      p.segment(begin, count) = z.segment(begin, count) + beta * p.segment(begin, count);
    });
  }
  return iteration;
}

}  // namespace burin
