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

// Pixels of an image, given by their row-major indices, to loop over.
class PixelRange {
 public:
  PixelRange(const uint32_t* begin, const uint32_t* end, int width)
      : begin_{begin, width, 1.0 / width}, end_(end) {}

  class Iterator {
   public:
    Iterator(const uint32_t* at, int width, double rows_per_pixel)
        : at_(at), width_(width), rows_per_pixel_(rows_per_pixel) {}
    // Without integer divisions; the half keeps the quotient off whole numbers.
    ImagePixel operator*() const {
      const int row = static_cast<int>((*at_ + 0.5) * rows_per_pixel_);
      return {*at_, static_cast<int>(*at_) - row * width_, row};
    }
    Iterator& operator++() {
      ++at_;
      return *this;
    }
    bool operator!=(const uint32_t* end) const { return at_ != end; }

   private:
    friend class PixelRange;
    const uint32_t* at_;
    int width_;
    double rows_per_pixel_;
  };
  const Iterator& begin() const { return begin_; }
  const uint32_t* end() const { return end_; }
  size_t size() const { return static_cast<size_t>(end_ - begin_.at_); }

 private:
  Iterator begin_;
  const uint32_t* end_;
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

// The pixels of a view by the corner of their facet with the largest barycentric coordinate at their
// surface point. Corner c of the k-th visible facet owns pixel[start[3k+c]] .. pixel[start[3k+c+1]-1],
// row-major pixel indices in ascending order.
struct ViewDomain : ViewPartners {
  int width = 0;
  int height = 0;
  std::vector<int> facet;       // visible facets, ascending
  std::vector<uint32_t> start;  // 3 * facet.size() + 1
  std::vector<uint32_t> pixel;

  // The pixels of the k-th visible facet, and those of its corner c.
  PixelRange PixelsOf(size_t k) const {
    return {pixel.data() + start[3 * k], pixel.data() + start[3 * k + 3], width};
  }
  PixelRange PixelsOf(size_t k, int c) const {
    return {pixel.data() + start[3 * k + c], pixel.data() + start[3 * k + c + 1], width};
  }

  // Fills width, height and the lists with the facets that the camera sees from the front (FacesCenter). The pixels
  // that see one from behind go to `behind`.
  void ListPixels(const TriangleMesh& mesh, const Camera& camera, const CornerMap& map,
                  std::vector<PixelDepth>* behind);
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
