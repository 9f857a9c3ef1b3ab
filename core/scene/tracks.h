// Where structure from motion measured the sparse points in the photographs: flat arrays, 24 bytes a
// measurement.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace burin {

struct Measurement {
  static constexpr std::uint32_t kNoKeypoint = std::numeric_limits<std::uint32_t>::max();

  Eigen::Vector2d image_point;  // pixels
  int view = 0;                 // index into the scene's views
  std::uint32_t keypoint =
      kNoKeypoint;  // its number among those of its photograph, where there is one
};

class Tracks {
 public:
  struct Range {
    const Measurement* first = nullptr;
    const Measurement* last = nullptr;
    const Measurement* begin() const { return first; }
    const Measurement* end() const { return last; }
    std::size_t size() const { return last - first; }
  };

  // Those added from now on are of the next point.
  void BeginPoint() { begin_.push_back(measurements_.size()); }
  void Add(const Measurement& measurement) { measurements_.push_back(measurement); }

  // Those of one point, in no order; a view may have several. None beyond the points begun.
  Range Of(std::size_t point) const {
    if (point >= begin_.size()) return {};
    const std::size_t end = point + 1 < begin_.size() ? begin_[point + 1] : measurements_.size();
    return {measurements_.data() + begin_[point], measurements_.data() + end};
  }

  // Moves all by what their view has in `offset`.
  void Shift(const std::vector<Eigen::Vector2d>& offset) {
    for (Measurement& measured : measurements_) measured.image_point += offset[measured.view];
  }

  // Scales all by what their view has in `factor`.
  void Scale(const std::vector<Eigen::Vector2d>& factor) {
    for (Measurement& measured : measurements_) {
      measured.image_point = measured.image_point.cwiseProduct(factor[measured.view]);
    }
  }

  std::size_t PointCount() const { return begin_.size(); }
  std::size_t Count() const { return measurements_.size(); }
  bool IsEmpty() const { return measurements_.empty(); }

 private:
  std::vector<std::size_t> begin_;  // a point
  std::vector<Measurement> measurements_;
};

}  // namespace burin
