// Evaluations as tables for people and as JSON for programs: a section a protocol.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "core/evaluation.h"

namespace burin {

// An aligned table of several lines, lengths in Evaluation::unit, shares in percent, ending in a
// newline.
std::string EvaluationReport(const Evaluation& evaluation);

// Everything the table says, lengths in world units, shares in [0, 1], and how it was measured.
nlohmann::json ToJson(const Evaluation& evaluation);

}  // namespace burin
