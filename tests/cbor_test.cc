#include "core/support/cbor.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace burin {
namespace {

using nlohmann::json;

json Read(const std::vector<unsigned char>& bytes) { return ReadCbor(bytes.data(), bytes.size()); }

TEST(Cbor, WhatIsWrittenIsRead) {
  const json value = {{"a", {1, -2, 3.5, true, nullptr, std::string(300, 'x')}},
                      {"b", json::binary({1, 2, 3})},
                      {"c", {{"d", {{"e", json::array({json::array(), 70000})}}}}}};
  EXPECT_EQ(Read(json::to_cbor(value)), value);
}

TEST(Cbor, DeepNestingIsRefusedBeforeTheStackIsUsedUp) {
  // [[[..., {0: {0: ..., indefinite arrays, strings in pieces, tags.
  for (const std::vector<unsigned char>& piece : {std::vector<unsigned char>{0x81},
                                                  {0xa1, 0x00},
                                                  {0x9f},
                                                  {0x5f},
                                                  {0xbf, 0x00},
                                                  {0xc1},
                                                  {0x9b, 0, 0, 0, 0, 0, 0, 0, 1}}) {
    std::vector<unsigned char> bytes;
    for (int k = 0; k < 1000000; ++k) bytes.insert(bytes.end(), piece.begin(), piece.end());
    EXPECT_THROW(Read(bytes), std::runtime_error) << int{piece[0]};
  }
}

TEST(Cbor, WhatIsCutIsRefused) {
  const std::vector<unsigned char> bytes = json::to_cbor({{"a", {1, 2.5, "text", {{"b", 300}}}}});
  for (size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_ANY_THROW(Read({bytes.begin(), bytes.begin() + static_cast<long>(size)})) << size;
  }
}

}  // namespace
}  // namespace burin
