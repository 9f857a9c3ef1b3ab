#include "core/evidence/match_grid.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace burin {
namespace {

constexpr int kTaps = kWindowSide * kWindowSide;
constexpr int kPatchRows = kGridRows + 2 * kWindowRadius;
constexpr int kPatchColumns = kGridColumns + 2 * kWindowRadius;
constexpr double kLeastSquares = 1e-3;  // below it a window counts as constant

float Sample(const cv::Mat1f& image, const Eigen::Vector2d& at) {
  const double x = at.x() - 0.5;
  const double y = at.y() - 0.5;
  const int column = static_cast<int>(x);
  const int row = static_cast<int>(y);
  const auto fx = static_cast<float>(x - column);
  const auto fy = static_cast<float>(y - row);
  const float* above = image[row] + column;
  const float* below = image[row + 1] + column;
  return (1 - fy) * ((1 - fx) * above[0] + fx * above[1]) +
         fy * ((1 - fx) * below[0] + fx * below[1]);
}

// A grid of so many places to each side is in the image.
bool Contains(const cv::Mat1f& image, const SampleGrid& grid, int along, int across) {
  for (const int a : {-along, along}) {
    for (const int b : {-across, across}) {
      if (!InsideForSampling(image, grid.At(a, b))) return false;
    }
  }
  return true;
}

// Sums of `values`^power over windows, for every place of the grid.
template <typename Patch>
std::array<std::array<double, kGridColumns>, kGridRows> WindowSums(const Patch& values,
                                                                   bool squared) {
  std::array<std::array<double, kGridColumns>, kGridRows> sums = {};
  std::array<double, kPatchColumns> columns = {};
  const auto add = [&](int row, double sign) {
    for (int a = 0; a < kPatchColumns; ++a) {
      const double value = values[row][a];
      columns[a] += sign * (squared ? value * value : value);
    }
  };
  for (int row = 0; row < kPatchRows; ++row) {
    add(row, 1);
    if (row >= kWindowSide) add(row - kWindowSide, -1);
    if (row < kWindowSide - 1) continue;
    double sum = 0;
    for (int a = 0; a < kPatchColumns; ++a) {
      sum += columns[a];
      if (a >= kWindowSide) sum -= columns[a - kWindowSide];
      if (a >= kWindowSide - 1) sums[row - kWindowSide + 1][a - kWindowSide + 1] = sum;
    }
  }
  return sums;
}

}  // namespace

bool InsideForSampling(const cv::Mat1f& image, const Eigen::Vector2d& at) {
  return at.x() > 1 && at.y() > 1 && at.x() < image.cols - 1.01 && at.y() < image.rows - 1.01;
}

GridPeak PeakOf(const GridScores& scores) {
  int row = 0;
  int column = 0;
  for (int b = 0; b < kGridRows; ++b) {
    for (int a = 0; a < kGridColumns; ++a) {
      if (scores[b][a] > scores[row][column]) {
        row = b;
        column = a;
      }
    }
  }
  GridPeak peak;
  peak.score = scores[row][column];
  peak.row = row - kMatchAcross;
  peak.along = column - kMatchAlong;
  peak.across = peak.row;
  for (int b = 0; b < kGridRows; ++b) {
    for (int a = 0; a < kGridColumns; ++a) {
      if (std::abs(a - column) <= kPeakReach && std::abs(b - row) <= kPeakReach) continue;
      peak.second = std::max(peak.second, scores[b][a]);
    }
  }
  peak.inside = row > 0 && column > 0 && row < kGridRows - 1 && column < kGridColumns - 1;
  if (!peak.inside) return peak;
  const auto at = [&](int a, int b) -> double { return scores[row + b][column + a]; };
  Eigen::Matrix2d hessian;
  hessian(0, 0) = at(1, 0) - 2 * at(0, 0) + at(-1, 0);
  hessian(1, 1) = at(0, 1) - 2 * at(0, 0) + at(0, -1);
  hessian(0, 1) = hessian(1, 0) = (at(1, 1) - at(1, -1) - at(-1, 1) + at(-1, -1)) / 4;
  if (hessian.determinant() > 1e-9) {
    const Eigen::Vector2d gradient((at(1, 0) - at(-1, 0)) / 2, (at(0, 1) - at(0, -1)) / 2);
    const Eigen::Vector2d step = -hessian.inverse() * gradient;
    peak.along += std::clamp(step.x(), -1.0, 1.0);
    peak.across += std::clamp(step.y(), -1.0, 1.0);
  }
  return peak;
}

GridWindow::GridWindow(const cv::Mat1f& image, const SampleGrid& grid) {
  valid_ = Contains(image, grid, kWindowRadius, kWindowRadius);
  if (!valid_) return;
  double sum = 0;
  for (int b = 0; b < kWindowSide; ++b) {
    for (int a = 0; a < kWindowSide; ++a) {
      unit_[b][a] = Sample(image, grid.At(a - kWindowRadius, b - kWindowRadius));
      sum += unit_[b][a];
    }
  }
  const auto mean = static_cast<float>(sum / kTaps);
  double squares = 0;
  for (auto& row : unit_) {
    for (float& value : row) {
      value -= mean;
      squares += static_cast<double>(value) * value;
    }
  }
  contrast_ = std::sqrt(squares / kTaps);
  const auto factor = static_cast<float>(squares > kLeastSquares ? 1 / std::sqrt(squares) : 0);
  for (auto& row : unit_) {
    for (float& value : row) value *= factor;
  }
}

std::optional<float> GridWindow::ScoreAt(const cv::Mat1f& image, const SampleGrid& grid) const {
  const GridWindow other(image, grid);
  if (!other.valid()) return std::nullopt;
  float score = 0;
  for (int b = 0; b < kWindowSide; ++b) {
    for (int a = 0; a < kWindowSide; ++a) score += unit_[b][a] * other.unit_[b][a];
  }
  return score;
}

std::optional<GridScores> GridWindow::ScoresAround(const cv::Mat1f& image,
                                                   const SampleGrid& grid) const {
  if (!Contains(image, grid, kMatchAlong + kWindowRadius, kMatchAcross + kWindowRadius)) {
    return std::nullopt;
  }
  std::array<std::array<float, kPatchColumns>, kPatchRows> patch;
  for (int b = 0; b < kPatchRows; ++b) {
    for (int a = 0; a < kPatchColumns; ++a) {
      patch[b][a] =
          Sample(image, grid.At(a - kMatchAlong - kWindowRadius, b - kMatchAcross - kWindowRadius));
    }
  }
  const auto sums = WindowSums(patch, /*squared=*/false);
  const auto squares = WindowSums(patch, /*squared=*/true);
  GridScores scores = {};
  for (int b = 0; b < kGridRows; ++b) {
    std::array<float, kGridColumns>& row = scores[b];
    for (int v = 0; v < kWindowSide; ++v) {
      for (int u = 0; u < kWindowSide; ++u) {
        const float tap = unit_[v][u];
        const float* values = patch[b + v].data() + u;
        for (int a = 0; a < kGridColumns; ++a) row[a] += tap * values[a];
      }
    }
    for (int a = 0; a < kGridColumns; ++a) {
      const double variance = squares[b][a] - sums[b][a] * sums[b][a] / kTaps;
      row[a] = variance > kLeastSquares ? row[a] / static_cast<float>(std::sqrt(variance)) : 0;
    }
  }
  return scores;
}

}  // namespace burin
