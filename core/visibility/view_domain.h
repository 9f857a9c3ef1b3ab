// What a view sees, as lists of pixels per facet corner, and which of its partners see that too.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/scene/camera.h"
#include "core/visibility/facet_map.h"
#include "core/visibility/partner_bits.h"

namespace burin {

// A pixel of an image and the image point at its centre (core/scene/camera.h).
struct ImagePixel {
  uint32_t index;  // row-major
  int column;
  int row;
  double x() const { return column + 0.5; }
  double y() const { return row + 0.5; }
};

// Pixels of an image to loop over.
class PixelRange {
 public:
  // A pixel within 256 columns and rows of the box that begins at (first_column, first_row): 256 rows + columns from there.
  PixelRange(const uint16_t* near, size_t count, int first_column, int first_row, int width)
      : begin_{near, nullptr, first_column, first_row, width, 0}, count_(count) {}
  // Row-major indices.
  PixelRange(const uint32_t* far, size_t count, int width)
      : begin_{nullptr, far, 0, 0, width, 1.0 / width}, count_(count) {}

  class Iterator {
   public:
    Iterator(const uint16_t* near, const uint32_t* far, int first_column, int first_row, int width,
             double rows_per_pixel)
        : near_(near),
          far_(far),
          first_column_(first_column),
          first_row_(first_row),
          width_(width),
          rows_per_pixel_(rows_per_pixel) {}
    ImagePixel operator*() const {
      if (near_ != nullptr) {
        const int column = first_column_ + near_[at_] % kNear;
        const int row = first_row_ + near_[at_] / kNear;
        return {static_cast<uint32_t>(row) * static_cast<uint32_t>(width_) +
                    static_cast<uint32_t>(column),
                column, row};
      }
      // Without an integer division; the half keeps the quotient off whole numbers.
      const int row = static_cast<int>((far_[at_] + 0.5) * rows_per_pixel_);
      return {far_[at_], static_cast<int>(far_[at_]) - row * width_, row};
    }
    Iterator& operator++() {
      ++at_;
      return *this;
    }
    bool operator!=(size_t end) const { return at_ != end; }

   private:
    const uint16_t* near_;
    const uint32_t* far_;
    int first_column_;
    int first_row_;
    int width_;
    double rows_per_pixel_;
    size_t at_ = 0;
  };
  const Iterator& begin() const { return begin_; }
  size_t end() const { return count_; }
  size_t size() const { return count_; }

  static constexpr int kNear = 256;

 private:
  Iterator begin_;
  size_t count_;
};

// A pixel's row-major index and the inverse depth of what it sees.
struct PixelDepth {
  uint32_t pixel;
  float inverse_depth;
};

// The regions Omega_ij of a reference view i.
struct ViewPartners {
  std::vector<int> seconds;          // views j, in the order of the bits below
  PartnerBits second_visible;        // pixel p is in Omega_ij
  std::vector<int64_t> pair_pixels;  // |Omega_ij| for each of `seconds`
};

// The pixels of a view by the corner of their facet with the largest barycentric coordinate at their surface point. Corner
// c of the k-th visible facet owns entries start[3k+c] .. start[3k+c+1]-1 of the list, pixels in row-major order. An
// entry has two bytes, or four where the view sees a facet that is higher or wider than PixelRange::kNear.
class ViewDomain : public ViewPartners {
 public:
  int width = 0;
  int height = 0;
  std::vector<int> facet;       // visible facets, ascending
  std::vector<uint32_t> start;  // 3 * facet.size() + 1

  size_t PixelCount() const { return start.empty() ? 0 : start.back(); }
  // The pixels of the k-th visible facet, and those of its corner c.
  PixelRange PixelsOf(size_t k) const { return Range(k, start[3 * k], start[3 * k + 3]); }
  PixelRange PixelsOf(size_t k, int c) const {
    return Range(k, start[3 * k + c], start[3 * k + c + 1]);
  }

  // Fills width, height and the lists with the facets that the camera sees from the front (FacesCenter). The pixels
  // that see one from behind go to `behind`.
  void ListPixels(const TriangleMesh& mesh, const Camera& camera, const CornerMap& map,
                  std::vector<PixelDepth>* behind);

 private:
  struct BoxCorner {
    uint16_t column;
    uint16_t row;
  };
  PixelRange Range(size_t k, uint32_t begin, uint32_t end) const {
    if (boxes_.empty()) return {far_.data() + begin, end - begin, width};
    return {near_.data() + begin, end - begin, boxes_[k].column, boxes_[k].row, width};
  }

  std::vector<BoxCorner>
      boxes_;  // of each visible facet's pixels; none where the entries have four bytes
  std::vector<uint16_t> near_;
  std::vector<uint32_t> far_;
};

// Of ViewDomain or ViewPartners, which must outlive the result.
template <typename View>
std::vector<const ViewPartners*> PartnersOf(const std::vector<View>& views) {
  std::vector<const ViewPartners*> partners;
  partners.reserve(views.size());
  for (const View& view : views) partners.push_back(&view);
  return partners;
}

}  // namespace burin
