#include "apps/run/closing.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/support/fixed_text.h"

namespace burin {
namespace {

using nlohmann::ordered_json;

// Good scenes end below 0.6, and photographs under wrong names above 0.79 (docs/guard.md).
constexpr double kNoAgreement = 0.75;
constexpr double kLargePart = 0.25;

bool AgreesWithNeither(const HeldBackVerdict& change) {
  return std::min(change.before, change.after) > kNoAgreement;
}

std::string ChangeText(const ClosingFigures& figures) {
  const HeldBackVerdict& change = *figures.held_back;
  return "mean 1 - ZNCC on held-back " + figures.judged_by + " " + Fixed(change.before, 3) +
         " -> " + Fixed(change.after, 3);
}

std::string OutcomeText(const ClosingFigures& figures) {
  switch (OutcomeOf(figures)) {
    case RunOutcome::kUndone:
      return "undone: the input surface is returned";
    case RunOutcome::kCannotTell:
      if (figures.held_back.has_value() && figures.held_back->Known()) {
        return "cannot tell whether it worked: photographs held back agree with neither surface, " +
               ChangeText(figures);
      }
      return "cannot tell whether it worked: too few windows are held back to judge by";
    default:
      return NameOf(OutcomeOf(figures)) + ": " + ChangeText(figures);
  }
}

ordered_json OrNull(const std::optional<double>& figure) {
  return figure.has_value() ? ordered_json(*figure) : ordered_json();
}

}  // namespace

RunOutcome OutcomeOf(const ClosingFigures& figures) {
  if (!figures.moved) return RunOutcome::kUndone;
  if (!figures.held_back.has_value() || !figures.held_back->Known()) return RunOutcome::kCannotTell;
  const HeldBackVerdict& change = *figures.held_back;
  if (AgreesWithNeither(change)) return RunOutcome::kCannotTell;
  if (change.Worse()) return RunOutcome::kWorse;
  if (!change.Better()) return RunOutcome::kLittle;
  const double unknown = figures.against.value_or(0) + figures.featureless.value_or(0);
  return unknown > kLargePart ? RunOutcome::kWorkedInPart : RunOutcome::kWorked;
}

std::string ClosingLine(const ClosingFigures& figures) {
  std::string line = OutcomeText(figures);
  std::vector<std::string> shares;
  if (figures.unseen.has_value()) {
    shares.push_back(PercentText(*figures.unseen) + " of the surface is seen by no pair");
  }
  if (figures.against.has_value()) {
    shares.push_back(PercentText(*figures.against) + " is against the evidence");
  }
  if (figures.featureless.value_or(0) > 0) {
    shares.push_back(PercentText(*figures.featureless) + " shows no texture to go by");
  }
  if (figures.parts_out > 0) {
    shares.push_back(std::to_string(figures.parts_out) + " of " + std::to_string(figures.parts) +
                     " parts, " + PercentText(figures.parts_out_area) +
                     " of the area, took no part");
  }
  if (!figures.hidden_view.empty()) {
    shares.push_back(PercentText(figures.hidden_share) + " of " + figures.hidden_view +
                     " is hidden by surface in free space");
  }
  if (figures.back_faces_after.has_value()) {
    shares.push_back(PercentText(*figures.back_faces_after) + " of the pixels see back faces");
  }
  if (figures.crossing_facets.has_value()) {
    shares.push_back(PercentText(*figures.crossing_facets) + " of the facets cross others");
  }
  for (size_t k = 0; k < shares.size(); ++k) line += (k == 0 ? "; " : ", ") + shares[k];
  return line;
}

ordered_json ClosingJson(const ClosingFigures& figures) {
  ordered_json json;
  json["outcome"] = NameOf(OutcomeOf(figures));
  json["line"] = ClosingLine(figures);
  json["held_back"] = nullptr;
  if (figures.held_back.has_value()) {
    const HeldBackVerdict& change = *figures.held_back;
    json["held_back"] = {{"by", figures.judged_by},
                         {"image", {figures.width, figures.height}},
                         {"before", change.before},
                         {"after", change.after},
                         {"standard_error", change.standard_error},
                         {"windows", change.windows}};
  }
  json["unseen_share"] = OrNull(figures.unseen);
  json["against_share"] = OrNull(figures.against);
  json["featureless_share"] = OrNull(figures.featureless);
  json["parts_out"] = {
      {"count", figures.parts_out}, {"of", figures.parts}, {"area_share", figures.parts_out_area}};
  json["hidden"] = nullptr;
  if (!figures.hidden_view.empty()) {
    json["hidden"] = {{"view", figures.hidden_view}, {"share", figures.hidden_share}};
  }
  json["back_faces"] = {{"before", OrNull(figures.back_faces_before)},
                        {"after", OrNull(figures.back_faces_after)}};
  json["crossing_facets_share"] = OrNull(figures.crossing_facets);
  json["seconds"] = figures.seconds;
  return json;
}

}  // namespace burin
