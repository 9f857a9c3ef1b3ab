// Bits of eleven partners, which need two planes, against a table of bool.
#include "core/visibility/partner_bits.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/visibility/view_domain.h"

namespace burin {
namespace {

constexpr size_t kPartners = 11;
constexpr size_t kPixels = 30;

bool InTable(size_t partner, size_t pixel) { return (7 * partner + 5 * pixel) % 12 < 4; }

PartnerBits FromTable() {
  PartnerBits bits(kPartners, kPixels);
  for (size_t b = 0; b < kPartners; ++b) {
    for (size_t p = 0; p < kPixels; ++p) {
      if (InTable(b, p)) bits.Set(b, p);
    }
  }
  return bits;
}

TEST(PartnerBits, HoldWhatIsSetAndCleared) {
  PartnerBits bits = FromTable();
  bits.Clear(9, 4);
  bits.Clear(9, 4);
  for (size_t b = 0; b < kPartners; ++b) {
    for (size_t p = 0; p < kPixels; ++p) {
      const bool expected = InTable(b, p) && !(b == 9 && p == 4);
      EXPECT_EQ(bits.Test(b, p), expected);
      EXPECT_EQ(bits.Of(b).Has(p), expected);
    }
  }
}

TEST(PartnerBits, OfAllPartnersAtOnePixel) {
  PartnerBits bits(kPartners, kPixels);
  bits.Set(2, 7);
  bits.Set(10, 7);
  EXPECT_TRUE(bits.Any(7));
  EXPECT_EQ(bits.Count(7), 2);
  EXPECT_FALSE(bits.Any(6) || bits.Any(8));
  const PartnerBits table = FromTable();
  bits.Copy(7, table);
  for (size_t b = 0; b < kPartners; ++b) EXPECT_EQ(bits.Test(b, 7), InTable(b, 7));
  bits.ClearAll(7);
  EXPECT_TRUE(bits == PartnerBits(kPartners, kPixels));
  EXPECT_FALSE(bits == table);
  EXPECT_FALSE(PartnerBits().Any(0));
}

TEST(PartnerBits, UniteARunOfPixels) {
  const PartnerBits table = FromTable();
  PartnerBits any(kPartners, 2);
  any.Set(10, 1);
  any.Unite(1, table, 5, 2);
  for (size_t b = 0; b < kPartners; ++b) {
    EXPECT_FALSE(any.Test(b, 0));
    EXPECT_EQ(any.Test(b, 1), b == 10 || InTable(b, 5) || InTable(b, 6));
  }
}

TEST(PixelRange, CentresOfTheFirstAndLastPixelsOfRows) {
  for (const int width : {1, 3, 641, 16384, 65535}) {
    std::vector<uint32_t> indices;
    for (const uint32_t row : {0U, 1U, 2U, 4095U, 32766U}) {
      indices.push_back(row * width);
      indices.push_back(row * width + width - 1);
    }
    size_t n = 0;
    for (const ImagePixel pixel : PixelRange(indices.data(), 10, width)) {
      EXPECT_EQ(pixel.index, indices[n]);
      EXPECT_EQ(pixel.row, static_cast<int>(indices[n] / width));
      EXPECT_EQ(pixel.column, n % 2 == 0 ? 0 : width - 1);
      EXPECT_EQ(pixel.x(), pixel.column + 0.5);
      EXPECT_EQ(pixel.y(), pixel.row + 0.5);
      ++n;
    }
    EXPECT_EQ(n, 10U);
  }
}

TEST(PixelRange, NearPixelsCountFromTheirBox) {
  const std::vector<uint16_t> near = {0, 255, 256, 65535};
  const int columns[4] = {70, 325, 70, 325};
  const int rows[4] = {9, 9, 10, 264};
  size_t n = 0;
  for (const ImagePixel pixel : PixelRange(near.data(), near.size(), 70, 9, 640)) {
    EXPECT_EQ(pixel.column, columns[n]);
    EXPECT_EQ(pixel.row, rows[n]);
    EXPECT_EQ(pixel.index, static_cast<uint32_t>(640 * rows[n] + columns[n]));
    ++n;
  }
  EXPECT_EQ(n, 4U);
}

}  // namespace
}  // namespace burin
