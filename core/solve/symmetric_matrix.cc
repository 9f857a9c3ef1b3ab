#include "core/solve/symmetric_matrix.h"

#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kChunk = 8192;

}  // namespace

void SymmetricMatrix::Multiply(const Eigen::VectorXd& x, const Eigen::VectorXd& damping,
                               Eigen::VectorXd* y) const {
  y->resize(size);
  const bool damped = damping.size() > 0;
  ForChunks(size, [&](int begin, int end) {
    for (int row = begin; row < end; ++row) {
      double sum = damped ? damping[row] * x[row] : 0.0;
      for (int64_t k = start[row]; k < start[row + 1]; ++k) sum += value[k] * x[column[k]];
      (*y)[row] = sum;
    }
  });
}

Eigen::VectorXd SymmetricMatrix::Diagonal() const {
  Eigen::VectorXd result(size);
  for (int row = 0; row < size; ++row) result[row] = value[diagonal[row]];
  return result;
}

double ChunkedSum(int count, const std::function<double(int, int)>& f) {
  std::vector<double> partial((count + kChunk - 1) / kChunk);
  ParallelFor(count, kChunk, [&](int begin, int end) { partial[begin / kChunk] = f(begin, end); });
  double sum = 0;
  for (double p : partial) sum += p;
  return sum;
}

double Dot(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  return ChunkedSum(static_cast<int>(a.size()), [&](int begin, int end) {
    return a.segment(begin, end - begin).dot(b.segment(begin, end - begin));
  });
}

void ForChunks(int count, const std::function<void(int, int)>& f) { ParallelFor(count, kChunk, f); }

}  // namespace burin
