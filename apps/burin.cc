// The burin program: parses the command line and hands over to one command.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <iostream>

namespace {

int Run(int argc, char** argv) {
  CLI::App app{"burin: photometric refinement of triangle meshes"};
  app.set_version_flag("--version", "burin 0.1.0");
  CLI11_PARSE(app, argc, argv);
  std::cout << app.help();
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return Run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "burin: error: %s\n", error.what());
    return 1;
  }
}
