#include "costs/pair_rows.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/support/parallel.h"

namespace burin {
namespace {

constexpr double kVertexShare = 1e-9;  // of B's trace, added to its diagonal
constexpr double kPairShare =
    1e-9;  // of K's diagonal, added to that of K'; tenfold while that is not enough
constexpr int kPairTries = 9;

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

}  // namespace

PairRows::PairRows(const RoundContext& context, const PairSample& sample, const CameraSums& sums)
    : rows_(sums.coupling.rows), pairs_(sums.pairs.size()) {
  const std::vector<Eigen::Vector3i>& faces = context.mesh->faces;
  std::vector<int> in_pair(context.mesh->vertices.size(), -1);  // the last pair
  vertices_.start.assign(1, 0);
  for (size_t i = 0; i < sums.first_pair.size(); ++i) {
    const std::vector<int>& facets = (*context.domains)[i].facet;
    const size_t partners = sample.partners[i]->seconds.size();
    const std::vector<char> in_pairs = FacetsInPairs((*context.domains)[i], sample.Pixels(i));
    for (size_t b = 0; b < partners; ++b) {
      const int pair = sums.first_pair[i] + static_cast<int>(b);
      pairs_[pair].first = sums.pairs[pair].first;
      pairs_[pair].second = sums.pairs[pair].second;
      for (size_t k = 0; k < facets.size(); ++k) {
        if (in_pairs[k * partners + b] == 0) continue;
        for (const int v : faces[facets[k]]) {
          if (in_pair[v] != pair) vertices_.index.push_back(v);
          in_pair[v] = pair;
        }
      }
      std::sort(vertices_.index.begin() + vertices_.start.back(), vertices_.index.end());
      vertices_.start.push_back(static_cast<int>(vertices_.index.size()));
    }
  }
  values_.resize(vertices_.index.size() * Stride());
}

void PairRows::Clear() { std::fill(values_.begin(), values_.end(), 0.0); }

void PairRows::Add(int pair, int vertex, const VertexSums& sums) {
  const int* found = std::lower_bound(vertices_.Begin(pair), vertices_.End(pair), vertex);
  double* values = At(static_cast<int>(found - vertices_.index.data()));
  Eigen::Map<RowMajor>(values, rows_, rows_) += sums.curvature.topLeftCorner(rows_, rows_);
  values += rows_ * rows_;
  Eigen::Map<Eigen::VectorXd>(values, rows_) += sums.gradient.head(rows_);
  values += rows_;
  Eigen::Map<RowMajor>(values, rows_, kCameras) += sums.coupling.leftCols(rows_).transpose();
}

double PairRows::FactorPair(const CameraSums::Pair& sums, int pair) {
  Eigen::Matrix<double, kCameras, kCameras> rest = sums.curvature;
  Row gradient = sums.gradient;
  double squares = 0;
  for (int place = vertices_.start[pair]; place < vertices_.start[pair + 1]; ++place) {
    Eigen::Map<RowMajor> curvature(At(place), rows_, rows_);
    Eigen::Map<Eigen::VectorXd> residuals(At(place) + rows_ * rows_, rows_);
    Eigen::Map<RowMajor> coupling(At(place) + rows_ * rows_ + rows_, rows_, kCameras);
    if (!(curvature.trace() > 0)) continue;  // no pixel of a window that counts: all are zero
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3> damped = curvature;
    damped.diagonal().array() += kVertexShare * curvature.trace();
    const Eigen::LLT<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3>> factor(damped);
    curvature = factor.matrixL();
    factor.matrixL().solveInPlace(residuals);
    factor.matrixL().solveInPlace(coupling);
    rest.noalias() -= coupling.transpose() * coupling;
    gradient.noalias() -= coupling.transpose() * residuals;
    squares += residuals.squaredNorm();
  }
  Pair& made = pairs_[pair];
  made.residuals.setZero();
  made.jacobian.setZero();
  const Row diagonal = sums.curvature.diagonal();
  if (!(diagonal.maxCoeff() > 0)) return squares;
  // A motion that no pixel sees keeps a number to divide by.
  const Row floor = diagonal.array().max(1e-12 * diagonal.maxCoeff());
  double share = kPairShare;
  for (int tries = 0; tries < kPairTries; ++tries, share *= 10) {
    Eigen::Matrix<double, kCameras, kCameras> damped = rest;
    damped.diagonal() += share * floor;
    const Eigen::LLT<Eigen::Matrix<double, kCameras, kCameras>> factor(damped);
    if (factor.info() != Eigen::Success) continue;
    made.residuals = factor.matrixL().solve(gradient);
    made.jacobian = factor.matrixU();
    break;
  }
  return squares + made.residuals.squaredNorm();
}

void PairRows::Factor(const CameraSums& sums, double energy, const std::vector<CameraPose>& poses) {
  motions_.clear();
  const Eigen::Matrix<double, CameraPose::kSize, CameraPose::kSize> numbers =
      Eigen::Matrix<double, CameraPose::kSize, CameraPose::kSize>::Identity();
  for (const CameraPose& pose : poses) {
    motions_.emplace_back(MotionsOf(pose, numbers.data(), CameraPose::kSize));
  }
  std::vector<double> squares(pairs_.size());
  ParallelFor(static_cast<int>(pairs_.size()), 1, [&](int begin, int end) {
    for (int p = begin; p < end; ++p) squares[p] = FactorPair(sums.pairs[p], p);
  });
  double sum = 0;
  for (const double part : squares) sum += part;
  const double beta_squared = energy > 0 ? std::max(1.0, sum / (2 * energy)) : 1;
  beta_ = std::sqrt(beta_squared);
  // Where there is no finite value, every pair says so: Ceres then tries a shorter step.
  const double left = 2 * energy - sum / beta_squared;
  rest_ = std::isfinite(left) ? std::sqrt(std::max(0.0, left) / std::max<double>(1, pairs_.size()))
                              : std::numeric_limits<double>::quiet_NaN();
}

void PairRows::OfVertex(int pair, int place, double* residuals, double* by_unknowns,
                        double* by_first, double* by_second) const {
  const double* values = At(place);
  const Eigen::Map<const RowMajor> factor(values, rows_, rows_);
  const Eigen::Map<const RowMajor> coupling(values + rows_ * rows_ + rows_, rows_, kCameras);
  for (int r = 0; r < rows_; ++r) residuals[r] = values[rows_ * rows_ + r] / beta_;
  if (by_unknowns != nullptr) {
    Eigen::Map<RowMajor>(by_unknowns, rows_, rows_) = beta_ * factor.transpose();
  }
  for (const bool second : {false, true}) {
    double* by = second ? by_second : by_first;
    if (by == nullptr) continue;
    const MotionOfPose& motion = motions_[second ? pairs_[pair].second : pairs_[pair].first];
    Eigen::Map<RowMajor>(by, rows_, CameraPose::kSize).noalias() =
        coupling.middleCols<6>(second ? 6 : 0) * motion / beta_;
  }
}

void PairRows::OfPair(int pair, double* residuals, double* by_first, double* by_second) const {
  const Pair& own = pairs_[pair];
  Eigen::Map<Row>(residuals, kCameras) = own.residuals / beta_;
  residuals[kCameras] = rest_;
  for (const bool second : {false, true}) {
    double* by = second ? by_second : by_first;
    if (by == nullptr) continue;
    Eigen::Map<RowMajor> jacobian(by, kPairResiduals, CameraPose::kSize);
    jacobian.topRows<kCameras>().noalias() = beta_ * own.jacobian.middleCols<6>(second ? 6 : 0) *
                                             motions_[second ? own.second : own.first];
    jacobian.bottomRows<1>().setZero();
  }
}

}  // namespace burin
