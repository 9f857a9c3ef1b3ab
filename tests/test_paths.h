// Where the program and the sources are; tests/CMakeLists.txt knows.
#pragma once

namespace burin::test {

extern const char* const kProgram;       // the built burin
extern const char* const kSourceFolder;  // the root of the repository

}  // namespace burin::test
