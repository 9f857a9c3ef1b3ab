#include "core/support/cbor.h"

#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <vector>

namespace burin {
namespace {

constexpr size_t kDeepest = 64;
constexpr uint64_t kUntilBreak = std::numeric_limits<uint64_t>::max();

// Walks the items without recursion. Stops at whatever is not well-formed: the library says what it is.
void CheckDepth(const unsigned char* bytes, size_t size) {
  std::vector<uint64_t> left = {1};  // items to come, at each level
  size_t at = 0;
  while (!left.empty()) {
    if (left.back() == 0) {
      left.pop_back();
      continue;
    }
    if (at >= size) return;
    const unsigned int type = bytes[at] >> 5;
    const unsigned int info = bytes[at] & 31U;
    ++at;
    if (type == 7 && info == 31) {  // break
      if (left.back() != kUntilBreak) return;
      left.pop_back();
      continue;
    }
    if (left.back() != kUntilBreak) --left.back();
    uint64_t argument = info;
    if (info >= 24 && info <= 27) {
      const size_t length = size_t{1} << (info - 24);
      if (size - at < length) return;
      argument = 0;
      for (size_t k = 0; k < length; ++k) argument = 256 * argument + bytes[at + k];
      at += length;
    } else if (info > 27 && info < 31) {
      return;
    } else if (info == 31) {
      argument = kUntilBreak;
    }
    switch (type) {
      case 2:  // bytes and text; of indefinite length, pieces until a break
      case 3:
        if (argument == kUntilBreak) {
          left.push_back(kUntilBreak);
        } else {
          if (argument > size - at) return;
          at += argument;
        }
        break;
      case 4:
        left.push_back(argument);
        break;
      case 5:
        if (argument != kUntilBreak && argument > size) return;
        left.push_back(argument == kUntilBreak ? kUntilBreak : 2 * argument);
        break;
      case 6:  // a tag, before an item
        left.push_back(1);
        break;
      default:
        break;
    }
    if (left.size() > kDeepest) throw std::runtime_error("is nested too deeply");
  }
}

}  // namespace

nlohmann::json ReadCbor(const unsigned char* bytes, size_t size) {
  CheckDepth(bytes, size);
  return nlohmann::json::from_cbor(bytes, bytes + size);
}

}  // namespace burin
