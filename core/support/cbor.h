// CBOR (RFC 8949) from a file that anybody may have written.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>

namespace burin {

// What nlohmann::json reads of it. Throws std::runtime_error for what is not CBOR, and for what is nested
// deeper than any file of burin's: the library's reader calls itself for every level, and a small file
// could make it run out of stack.
nlohmann::json ReadCbor(const unsigned char* bytes, size_t size);

}  // namespace burin
