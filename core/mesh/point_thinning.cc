#include "core/mesh/point_thinning.h"

#include <cmath>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "core/support/counter_random.h"

namespace burin {
namespace {

constexpr std::uint64_t kOrderStream = 0x7468696E;

// Kept points by cubes of twice the spacing: whatever is nearer than the spacing to a point lies in
// one of the eight cubes around the corner that is nearest to it.
class KeptPoints {
 public:
  KeptPoints(const std::vector<Eigen::Vector3d>& points, double spacing)
      : points_(points), spacing_(spacing), next_(points.size(), -1) {}

  // Keeps points[index] unless a kept one is too near.
  bool Keep(int index) {
    const Eigen::Vector3d& point = points_[index];
    const Eigen::Vector3d in_cubes = point / (2 * spacing_);
    const Eigen::Vector3d corner = (in_cubes.array() - 0.5).floor().matrix();
    for (int k = 0; k < 8; ++k) {
      const auto cube = first_.find(Key(corner + Eigen::Vector3d(k & 1, (k >> 1) & 1, k >> 2)));
      if (cube == first_.end()) continue;
      for (int other = cube->second; other >= 0; other = next_[other]) {
        if ((points_[other] - point).squaredNorm() < spacing_ * spacing_) return false;
      }
    }
    const auto [cube, is_new] = first_.emplace(Key(in_cubes.array().floor().matrix()), index);
    if (!is_new) next_[index] = std::exchange(cube->second, index);
    return true;
  }

 private:
  // Cubes that share a key by chance cost a few comparisons, no more.
  static std::uint64_t Key(const Eigen::Vector3d& cube) {
    std::uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      key = MixBits(key + 0x9E3779B97F4A7C15U +
                    static_cast<std::uint64_t>(static_cast<std::int64_t>(cube[axis])));
    }
    return key;
  }

  const std::vector<Eigen::Vector3d>& points_;
  double spacing_;
  std::unordered_map<std::uint64_t, int> first_;  // of the kept points in a cube
  std::vector<int> next_;                         // the kept point after each in its cube; -1: none
};

}  // namespace

std::vector<Eigen::Vector3d> Thinned(const std::vector<Eigen::Vector3d>& points, double spacing,
                                     std::uint64_t seed) {
  std::vector<int> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  const CounterRandom random(seed, kOrderStream);
  for (size_t k = order.size(); k > 1; --k) {  // Fisher and Yates
    std::swap(order[k - 1], order[static_cast<size_t>(random.Uniform(k) * static_cast<double>(k))]);
  }
  KeptPoints kept(points, spacing);
  std::vector<char> is_kept(points.size(), 0);
  for (const int index : order) is_kept[index] = kept.Keep(index) ? 1 : 0;
  std::vector<Eigen::Vector3d> thinned;
  for (size_t k = 0; k < points.size(); ++k) {
    if (is_kept[k] != 0) thinned.push_back(points[k]);
  }
  return thinned;
}

}  // namespace burin
