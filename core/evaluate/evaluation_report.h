// Evaluations as tables for people and as JSON for programs, with a section for each protocol.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "core/evaluate/camera_evaluation.h"
#include "core/evaluate/depth_evaluation.h"
#include "core/evaluate/dtu_evaluation.h"
#include "core/evaluate/evaluation.h"

namespace burin {

// An aligned table of several lines, lengths in Evaluation::unit, shares in percent, ending in a
// newline.
std::string EvaluationReport(const Evaluation& evaluation);

// The same for the other protocols, lengths in `unit` world units.
std::string DtuReport(const DtuEvaluation& evaluation, double unit);
std::string DepthReport(const DepthEvaluation& evaluation, double unit);
std::string CameraReport(const CameraEvaluation& evaluation, double unit);

// Everything the table says, lengths in world units, shares in [0, 1], and how it was measured.
nlohmann::json ToJson(const Evaluation& evaluation);
nlohmann::json ToJson(const DtuEvaluation& evaluation);
nlohmann::json ToJson(const DepthEvaluation& evaluation);
nlohmann::json ToJson(const CameraEvaluation& evaluation);

}  // namespace burin
