// The options of `burin evaluate`: the scores that are always made and the protocols beside them.
#pragma once

#include "core/evaluate/depth_evaluation.h"
#include "core/evaluate/dtu_evaluation.h"
#include "core/evaluate/evaluation.h"
#include "core/support/options.h"

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
