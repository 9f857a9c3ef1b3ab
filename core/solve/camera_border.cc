#include "core/solve/camera_border.h"

#include <glog/logging.h>

#include <algorithm>
#include <utility>

#include "core/support/median.h"
#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr int kVertexGrain = 4096;
constexpr int kMotion = CameraCoupling::kMotion;

}  // namespace

std::vector<Eigen::VectorXd> MedianDiagonals(std::vector<Eigen::VectorXd> diagonals) {
  std::vector<double> like[4];
  for (const Eigen::VectorXd& own : diagonals) {
    if (own.size() != kMotion) continue;
    for (int u = 0; u < 3; ++u) like[u].push_back(own[u]);
    like[3].push_back(own.tail<3>().mean());
  }
  for (Eigen::VectorXd& own : diagonals) {
    if (own.size() != kMotion) continue;
    for (int u = 0; u < kMotion; ++u) own[u] = Median(like[std::min(u, 3)]);
  }
  return diagonals;
}

void CameraBorder::Begin(const std::vector<Column>& columns, int camera_count,
                         std::vector<int> first_row) {
  columns_ = columns;
  column_of_.assign(camera_count, -1);
  int unknowns = 0;
  for (size_t k = 0; k < columns_.size(); ++k) {
    column_of_[columns_[k].camera] = static_cast<int>(k);
    unknowns += columns_[k].unknowns;
  }
  first_row_ = std::move(first_row);
  curvature_.setZero(unknowns, unknowns);
  motions_.resize(columns_.size());
  coupling_ = nullptr;
}

void CameraBorder::SetCoupling(const CameraCoupling* coupling,
                               const std::vector<const double*>& plus) {
  for (size_t k = 0; k < columns_.size(); ++k) {
    motions_[k] = MotionsOf(*columns_[k].pose, plus[k], columns_[k].unknowns);
  }
  const bool listed = coupling_ != nullptr;
  coupling_ = coupling;
  if (coupling_ != nullptr && !listed) ListVertices();
}

void CameraBorder::ListVertices() {
  const Adjacency& cameras = coupling_->cameras;
  CHECK_EQ(cameras.start.size(), first_row_.size() + 1);
  const auto for_all = [&](const auto& visit) {
    for (size_t v = 0; v < first_row_.size(); ++v) {
      if (first_row_[v] < 0) continue;
      const auto vertex = static_cast<int>(v);
      for (const int* c = cameras.Begin(vertex); c != cameras.End(vertex); ++c) {
        if (column_of_[*c] >= 0) visit(column_of_[*c], vertex);
      }
    }
  };
  vertices_.start.assign(columns_.size() + 1, 0);
  for_all([&](int column, int) { ++vertices_.start[column + 1]; });
  for (size_t k = 0; k < columns_.size(); ++k) vertices_.start[k + 1] += vertices_.start[k];
  vertices_.index.resize(vertices_.start.back());
  std::vector<int> next(vertices_.start.begin(), vertices_.start.end() - 1);
  for_all([&](int column, int vertex) { vertices_.index[next[column]++] = vertex; });
}

Eigen::VectorXd CameraBorder::MedianDiagonal() const {
  std::vector<Eigen::VectorXd> diagonals;
  for (const Column& column : columns_) {
    diagonals.emplace_back(curvature_.diagonal().segment(column.first, column.unknowns));
  }
  const std::vector<Eigen::VectorXd> medians = MedianDiagonals(std::move(diagonals));
  Eigen::VectorXd all(unknowns());
  for (size_t k = 0; k < columns_.size(); ++k) {
    all.segment(columns_[k].first, columns_[k].unknowns) = medians[k];
  }
  return all;
}

Eigen::VectorXd CameraBorder::ToMotions(const Eigen::VectorXd& z) const {
  Eigen::VectorXd motions(kMotion * static_cast<long>(columns_.size()));
  for (size_t k = 0; k < columns_.size(); ++k) {
    motions.segment<kMotion>(kMotion * static_cast<long>(k)) =
        motions_[k] * z.segment(columns_[k].first, columns_[k].unknowns);
  }
  return motions;
}

Eigen::VectorXd CameraBorder::FromMotions(const Eigen::VectorXd& motions) const {
  Eigen::VectorXd z(unknowns());
  for (size_t k = 0; k < columns_.size(); ++k) {
    z.segment(columns_[k].first, columns_[k].unknowns) =
        motions_[k].transpose() * motions.segment<kMotion>(kMotion * static_cast<long>(k));
  }
  return z;
}

Eigen::VectorXd CameraBorder::TransposedTimes(const Eigen::VectorXd& x) const {
  if (coupling_ == nullptr) return Eigen::VectorXd::Zero(unknowns());
  const int rows = coupling_->rows;
  const auto count = static_cast<int>(first_row_.size());
  // Of fixed ranges of vertices, added in their order.
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(kMotion * static_cast<long>(columns_.size()),
                                               (count + kVertexGrain - 1) / kVertexGrain);
  coupling_->ForBlocks([&](const auto* values) {
    ParallelFor(count, kVertexGrain, [&](int begin, int end) {
      double* sum = sums.col(begin / kVertexGrain).data();
      ForPlaces(begin, end, [&](int first_row, int column, int place) {
        const auto* block = values + static_cast<size_t>(place) * rows * kMotion;
        double* motion = sum + static_cast<ptrdiff_t>(column) * kMotion;
        for (int row = 0; row < rows; ++row) {
          const double along = x[first_row + row];
          for (int u = 0; u < kMotion; ++u) motion[u] += along * block[row * kMotion + u];
        }
      });
    });
  });
  return FromMotions(sums.rowwise().sum());
}

void CameraBorder::AddTimes(const Eigen::VectorXd& z, Eigen::VectorXd* x) const {
  if (coupling_ == nullptr) return;
  const Eigen::VectorXd motions = ToMotions(z);
  const int rows = coupling_->rows;
  coupling_->ForBlocks([&](const auto* values) {
    ParallelFor(static_cast<int>(first_row_.size()), kVertexGrain, [&](int begin, int end) {
      ForPlaces(begin, end, [&](int first_row, int column, int place) {
        const auto* block = values + static_cast<size_t>(place) * rows * kMotion;
        const double* motion = motions.data() + static_cast<ptrdiff_t>(column) * kMotion;
        for (int row = 0; row < rows; ++row) {
          double sum = 0;
          for (int u = 0; u < kMotion; ++u) sum += block[row * kMotion + u] * motion[u];
          (*x)[first_row + row] += sum;
        }
      });
    });
  });
}

void CameraBorder::Multiply(const Eigen::VectorXd& x, Eigen::VectorXd* y) const {
  const Eigen::VectorXd z = x.tail(unknowns());
  y->tail(unknowns()) = TransposedTimes(x) + curvature_ * z;
  AddTimes(z, y);
}

bool CameraBorder::Factor(const BlockJacobi& inverse, const Eigen::VectorXd& damping) {
  const auto motions = kMotion * static_cast<long>(columns_.size());
  Eigen::MatrixXd eliminated = Eigen::MatrixXd::Zero(motions, motions);  // lower: C^T B^-1 C
  if (coupling_ != nullptr) {
    const Adjacency& cameras = coupling_->cameras;
    const int rows = coupling_->rows;
    ParallelFor(static_cast<int>(columns_.size()), 1, [&](int begin, int end) {
      for (int k = begin; k < end; ++k) {
        for (const int* v = vertices_.Begin(k); v != vertices_.End(k); ++v) {
          const auto own = coupling_->Block(coupling_->Place(*v, columns_[k].camera));
          const Eigen::Matrix<double, kMotion, Eigen::Dynamic, 0, kMotion, 3> solved =
              own.transpose() * inverse.OfUnknown(first_row_[*v], rows);
          for (int place = cameras.start[*v]; place < cameras.start[*v + 1]; ++place) {
            const int column = column_of_[cameras.index[place]];
            if (column < 0 || column > k) continue;
            eliminated.block<kMotion, kMotion>(kMotion * k, kMotion * column) +=
                solved * coupling_->Block(place);
          }
        }
      }
    });
  }
  Eigen::MatrixXd schur = curvature_;
  schur.diagonal() += damping;
  for (size_t k = 0; k < columns_.size(); ++k) {
    for (size_t l = 0; l <= k; ++l) {
      schur.block(columns_[k].first, columns_[l].first, columns_[k].unknowns,
                  columns_[l].unknowns) -=
          motions_[k].transpose() *
          eliminated.block<kMotion, kMotion>(kMotion * static_cast<long>(k),
                                             kMotion * static_cast<long>(l)) *
          motions_[l];
    }
  }
  schur_.compute(schur);  // reads the lower triangle
  return schur_.info() == Eigen::Success;
}

void CameraBorder::ApplyInverse(const BlockJacobi& inverse, const Eigen::VectorXd& r,
                                Eigen::VectorXd* z) const {
  const long rows = r.size() - unknowns();
  const Eigen::VectorXd of_surface = r.head(rows);
  Eigen::VectorXd solved;
  inverse.Apply(of_surface, &solved);
  const Eigen::VectorXd cameras = schur_.solve(r.tail(unknowns()) - TransposedTimes(solved));
  // B^-1 (r - C cameras)
  Eigen::VectorXd rest = Eigen::VectorXd::Zero(rows);
  AddTimes(cameras, &rest);
  Eigen::VectorXd correction;
  inverse.Apply(rest, &correction);
  z->resize(r.size());
  z->head(rows) = solved - correction;
  z->tail(unknowns()) = cameras;
}

}  // namespace burin
