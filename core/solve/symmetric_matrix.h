// A sparse symmetric matrix by full rows, and sums over long vectors, on all threads: every row is
// owned by one thread and every sum has a fixed order, so results are the same bytes for any number
// of threads. Full rows cost twice the memory of a triangle and need no scattered writes.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

namespace burin {

struct SymmetricMatrix {
  int size = 0;
  std::vector<int64_t> start;  // size + 1
  std::vector<int> column;     // not sorted: the lower triangle of a row comes first
  std::vector<double> value;
  std::vector<int64_t> diagonal;  // position in `value` of each row's diagonal entry

  // y = (A + D) x with D diagonal; `damping` may be empty for D = 0.
  void Multiply(const Eigen::VectorXd& x, const Eigen::VectorXd& damping, Eigen::VectorXd* y) const;
  Eigen::VectorXd Diagonal() const;
};

// sum of f(begin, end) over fixed consecutive ranges of [0, count), added in order.
double ChunkedSum(int count, const std::function<double(int begin, int end)>& f);
double Dot(const Eigen::VectorXd& a, const Eigen::VectorXd& b);
// f(begin, end) over the same ranges, in parallel.
void ForChunks(int count, const std::function<void(int begin, int end)>& f);

}  // namespace burin
