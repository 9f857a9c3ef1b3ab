// Which partners of a view see the surface point of each of its pixels: a bit a pixel and partner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace burin {

// The pixels of one partner, as innermost loops read them.
struct PartnerPixels {
  const uint8_t* bytes = nullptr;  // one a pixel
  uint8_t bit = 1;
  bool Has(size_t pixel) const { return (bytes[pixel] & bit) != 0; }
};

// Kept in planes of one byte a pixel, eight partners to a plane: what is asked of one partner reads one
// byte a pixel, what is asked of all of them one byte for eight. Threads may change pixels at the same
// time, each its own.
class PartnerBits {
 public:
  PartnerBits() = default;
  PartnerBits(size_t partners, size_t pixels)  // none set
      : partners_(partners), pixels_(pixels), bytes_(BytesPerPixel(partners) * pixels, 0) {}

  static size_t BytesPerPixel(size_t partners) { return (partners + 7) / 8; }
  size_t partners() const { return partners_; }

  bool Test(size_t partner, size_t pixel) const { return Of(partner).Has(pixel); }
  void Set(size_t partner, size_t pixel) { Byte(partner, pixel) |= Bit(partner); }
  void Clear(size_t partner, size_t pixel) {
    uint8_t& byte = Byte(partner, pixel);
    byte = static_cast<uint8_t>(byte & ~Bit(partner));
  }
  // One a pixel, in which the bit of Of(partner) is the partner's.
  uint8_t* MutableBytes(size_t partner) { return bytes_.data() + partner / 8 * pixels_; }
  PartnerPixels Of(size_t partner) const {
    return {bytes_.data() + partner / 8 * pixels_, Bit(partner)};
  }

  // Of all partners at one pixel.
  bool Any(size_t pixel) const {
    uint8_t any = 0;
    for (size_t at = pixel; at < bytes_.size(); at += pixels_) any |= bytes_[at];
    return any != 0;
  }
  int Count(size_t pixel) const {
    int count = 0;
    for (size_t at = pixel; at < bytes_.size(); at += pixels_) {
      count += __builtin_popcount(bytes_[at]);
    }
    return count;
  }
  void ClearAll(size_t pixel) {
    for (size_t at = pixel; at < bytes_.size(); at += pixels_) bytes_[at] = 0;
  }
  // `from` has as many partners and pixels.
  void Copy(size_t pixel, const PartnerBits& from) {
    for (size_t at = pixel; at < bytes_.size(); at += pixels_) bytes_[at] = from.bytes_[at];
  }
  // Sets at `pixel` what is set at any of the `count` pixels of `from` that begin at `first`; `from`
  // has as many partners.
  void Unite(size_t pixel, const PartnerBits& from, size_t first, size_t count) {
    for (size_t at = pixel; at < bytes_.size(); at += pixels_, first += from.pixels_) {
      const uint8_t* source = from.bytes_.data() + first;
      uint8_t any = 0;
      for (size_t k = 0; k < count; ++k) any |= source[k];
      bytes_[at] |= any;
    }
  }

  bool operator==(const PartnerBits& other) const {
    return partners_ == other.partners_ && pixels_ == other.pixels_ && bytes_ == other.bytes_;
  }

 private:
  static uint8_t Bit(size_t partner) { return static_cast<uint8_t>(1U << (partner % 8)); }
  uint8_t& Byte(size_t partner, size_t pixel) { return bytes_[partner / 8 * pixels_ + pixel]; }

  size_t partners_ = 0;
  size_t pixels_ = 0;
  std::vector<uint8_t> bytes_;  // plane by plane
};

}  // namespace burin
