// The options of `burin evaluate`: the scores that are always made and the protocols beside them.
#pragma once

#include "core/depth_evaluation.h"
#include "core/dtu_evaluation.h"
#include "core/evaluation.h"
#include "core/options.h"

namespace burin {

struct EvaluateOptions {
  EvaluationOptions scores;
  DtuOptions dtu;
  StrechaOptions strecha;

  void Describe(OptionSet* set) {
    scores.Describe(set);
    dtu.Describe(set);
    strecha.Describe(set);
  }
};

}  // namespace burin
