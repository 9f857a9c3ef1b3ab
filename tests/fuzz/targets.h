// Every reader of burin as a function of bytes, and the refinement of a mesh that was read. The fuzzer uses them (fuzz_main.cc, `./run fuzz`), and so
// does the test that reads the files it found (tests/fuzz_corpus_test.cc).
#pragma once

#include <string>
#include <vector>

namespace burin::fuzz {

struct Target {
  const char* name;  // of its folder in corpus/
  // Reads `bytes`; a file that is refused (InputError) is a good outcome, as is one that is read.
  void (*run)(const std::string& bytes);
};

const std::vector<Target>& Targets();

}  // namespace burin::fuzz
