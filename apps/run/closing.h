// What a refinement came to, in one line and in summary.json: whether it helped, and what it does not know. Every
// figure is optional: what was not measured is not said.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "core/support/choices.h"
#include "costs/held_back.h"

namespace burin {

// kWorked: the change on what was held back is below minus two standard errors. kWorkedInPart: the same, and more
// than a quarter of the surface is against the evidence or featureless: no photograph tells where it is. kWorse: above
// two. kLittle: between them. kUndone: no vertex has moved. kCannotTell: too little was held back
// (HeldBackVerdict::Known), or it agrees with neither surface, 1 - ZNCC above 0.75 before and after.
enum class RunOutcome { kWorked, kWorkedInPart, kLittle, kWorse, kUndone, kCannotTell };
inline Choices<RunOutcome> ChoicesOf(RunOutcome) {
  return {{RunOutcome::kWorked, "worked"},         {RunOutcome::kWorkedInPart, "worked in part"},
          {RunOutcome::kLittle, "changed little"}, {RunOutcome::kWorse, "worse"},
          {RunOutcome::kUndone, "undone"},         {RunOutcome::kCannotTell, "cannot tell"}};
}

struct ClosingFigures {
  bool moved = true;  // some vertex is not where the input surface has it
  // From the input surface to the refined one, both cut into the same facets and seen on the same images.
  std::optional<HeldBackVerdict> held_back;
  std::string judged_by = "pairs";  // or "squares"
  int width = 0;                    // of the images that they were compared on
  int height = 0;
  // Shares of the refined surface's area.
  std::optional<double> unseen;   // by any pair
  std::optional<double> against;  // the evidence (apps/run/measure_closing.h)
  // Photographs do not agree there, and show no texture that they could agree on (the same).
  std::optional<double> featureless;
  // Connected parts of the input that no pair sees, and their share of its area.
  int parts_out = 0;
  int parts = 0;
  double parts_out_area = 0;
  // What facets in free space hide of the view that they hide most of (core/evidence/free_space.h); empty: none.
  std::string hidden_view;
  double hidden_share = 0;
  // Of the pixels that see the mesh, those that see its back, as the first level began and the last one ended.
  std::optional<double> back_faces_before;
  std::optional<double> back_faces_after;
  // Of the facets, as the last level ended, those that cross another one.
  std::optional<double> crossing_facets;
  double seconds = 0;  // to measure all this
};

RunOutcome OutcomeOf(const ClosingFigures& figures);

// "worked: mean 1 - ZNCC on held-back pairs 0.412 -> 0.287; 12.3 % of the surface is seen by no pair, ..."
std::string ClosingLine(const ClosingFigures& figures);

// `closing` of summary.json; figures that were not measured are null.
nlohmann::ordered_json ClosingJson(const ClosingFigures& figures);

}  // namespace burin
