// Options of `burin mesh`.
#pragma once

#include "apps/run/pipeline.h"
#include "core/support/options.h"
#include "reconstruct/start_options.h"

namespace burin {

struct MeshCommandOptions {
  StartOptions start;
  int threads = 0;  // 0 = all cores
  void Describe(OptionSet* set) {
    start.Describe(set);
    DescribeThreads(&threads, set);
  }
};

}  // namespace burin
