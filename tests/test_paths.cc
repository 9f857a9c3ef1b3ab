#include "tests/test_paths.h"

namespace burin::test {

const char* const kProgram = BURIN_PROGRAM;
const char* const kSourceFolder = BURIN_SOURCE_DIR;

}  // namespace burin::test
