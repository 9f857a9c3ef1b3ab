// libFuzzer's entry; BURIN_FUZZ_TARGET names the reader.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "tests/fuzz/targets.h"

namespace {

const burin::fuzz::Target& Chosen() {
  const char* name = std::getenv("BURIN_FUZZ_TARGET");
  for (const burin::fuzz::Target& target : burin::fuzz::Targets()) {
    if (name != nullptr && std::string(name) == target.name) return target;
  }
  std::fputs("BURIN_FUZZ_TARGET must be one of", stderr);
  for (const burin::fuzz::Target& target : burin::fuzz::Targets()) {
    std::fprintf(stderr, " %s", target.name);
  }
  std::fputs("\n", stderr);
  std::exit(2);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const burin::fuzz::Target& target = Chosen();
  target.run(std::string(reinterpret_cast<const char*>(data), size));
  return 0;
}
