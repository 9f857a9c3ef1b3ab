#include "apps/commands/refine_texts.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <sstream>

#include "core/support/fixed_text.h"
#include "core/support/listed.h"

namespace burin {
namespace {

std::string LevelName(const LevelSummary& level) {
  const std::string name =
      "level " + std::to_string(level.width) + "x" + std::to_string(level.height);
  return level.remeshed_faces > 0 ? name + " remeshed" : name;
}

// The guard's figures.
std::string ScoreText(const LevelSummary& level) {
  std::ostringstream text;
  text << "mean 1 - ZNCC " << level.held_back["before"].get<double>() << " -> "
       << level.held_back["after"].get<double>();
  return text.str();
}

// Why a level was undone.
std::string Disagreement(const LevelSummary& level, const std::string& when) {
  if (level.held_back["windows"].get<double>() <= 0) {
    return "photographs held back show nothing of the mesh to judge it by";
  }
  return "photographs held back agree less with the mesh " + when + ", " + ScoreText(level);
}

// Of the sum over this many windows.
std::string EnergyPerWindow(double energy, int64_t windows) {
  return windows > 0 ? Fixed(energy / static_cast<double>(windows), 4) : "-";
}

// Of a level whose splitting was stopped, or whose surface was cut anew into no more facets than it may have.
std::string UnsplitText(const LevelSummary& level) {
  std::ostringstream text;
  if (level.remeshed_faces > 0) {
    text << LevelName(level) << " remeshed: edges are longer than wanted, for " << level.faces
         << " faces (level.max_faces)";
    return text.str();
  }
  text << LevelName(level) << ": splitting stopped at " << level.faces
       << " faces (level.max_faces, or edges too short to split); some are larger than"
       << " level.max_facet_px or level.max_edge_px";
  return text.str();
}

std::string LeftOutText(const LevelSummary& level) {
  return LevelName(level) + " left out: no window of any pair is whole there";
}

// Of a level that was undone, or parts of it.
std::string UndoneText(const LevelSummary& level) {
  if (level.undone) return LevelName(level) + " undone: " + Disagreement(level, "after it");
  return LevelName(level) + ": parts of the mesh set back, " +
         std::to_string(level.undone_vertices) +
         " vertices: photographs held back agree less with them";
}

// What of the surface passes through itself, before a level and after it (guard.crossings).
std::string CrossingsText(const LevelSummary& level) {
  std::ostringstream text;
  text << LevelName(level) << ": facets that cross others " << level.crossing_facets.before
       << " -> " << level.crossing_facets.after << " of " << level.faces << ", back faces "
       << Fixed(100 * level.back_faces.before, 2) << " -> "
       << Fixed(100 * level.back_faces.after, 2) << " % of the mesh's pixels";
  if (level.TakenBack() > 0) {
    text << "; " << level.TakenBack() << " vertices stopped before they cross";
  }
  return text.str();
}

std::string RemeshedText(const LevelSummary& level) {
  return LevelName(level) + ": " + std::to_string(level.remeshed_faces) + " -> " +
         std::to_string(level.faces) + " facets";
}

// What became of the part of a level that was done when the run was stopped.
std::string InterruptedText(const LevelSummary& level) {
  const std::string name =
      LevelName(level) + " cut short in round " + std::to_string(level.rounds.back().round + 1);
  if (level.held_back.is_null()) return name + ", not judged (guard.levels is off)";
  if (level.undone) return name + " and undone: " + Disagreement(level, "so far");
  return name + ", kept: photographs held back do not agree less with the mesh so far, " +
         ScoreText(level);
}

}  // namespace

std::string EventText(const RefinementEvent& event) {
  std::ostringstream text;
  text << "level " << event.level << " round " << event.round + 1 << " iteration "
       << event.iteration.iteration << " energy per window "
       << EnergyPerWindow(event.iteration.energy, event.windows);
  return text.str();
}

std::string ViewsText(const RoundContext& context, const std::vector<std::string>& names) {
  std::vector<std::string> small;
  std::vector<std::string> coarse;
  for (size_t i = 0; i < names.size(); ++i) {
    const ViewAtLevel& at = (*context.views)[i].at;
    if (!at.takes_part) {
      small.push_back(names[i]);
    } else if (at.halvings != context.level) {
      coarse.push_back(names[i]);
    }
  }
  std::string text;
  if (!small.empty()) text = "left out, too small here (level.min_side_px): " + Listed(small);
  if (!small.empty() && !coarse.empty()) text += "; ";
  if (!coarse.empty()) {
    text += "reduced less than the others, as their pixels are coarser: " + Listed(coarse);
  }
  if (text.empty()) return text;
  const Camera& name = NamesLevel(*context.views).camera;
  return "level " + std::to_string(name.width) + "x" + std::to_string(name.height) + ": " + text;
}

namespace {

// "; contours 0.12 px outside the outlines, 3 % of them without one": over all views, by length.
std::string OutlinesText(const nlohmann::json& terms) {
  if (!terms.contains("silhouette")) return {};
  double length = 0;
  double outside = 0;
  double unmatched = 0;
  for (const nlohmann::json& view : terms["silhouette"]["views"]) {
    const double of_view = view["contour_px"];
    length += of_view;
    outside += of_view * view["signed_px"].get<double>();
    unmatched += of_view * view["unmatched"].get<double>();
  }
  if (length == 0) return {};
  return "; contours " + Fixed(std::abs(outside) / length, 2) + " px " +
         (outside < 0 ? "inside" : "outside") + " the outlines, " +
         PercentText(unmatched / length) + " of them without one";
}

}  // namespace

std::string RoundText(const RoundContext& context, const TriangleMesh& mesh,
                      const RoundSummary& round) {
  std::ostringstream text;
  const Camera& name = NamesLevel(*context.views).camera;
  text << "level " << name.width << "x" << name.height << " round " << round.round + 1 << ": "
       << mesh.faces.size() << " faces, " << round.pair_pixels << " pixel pairs, "
       << round.solve.strategy << " " << round.solve.iterations << " iterations, energy per window "
       << EnergyPerWindow(round.energy_initial["total"].get<double>(), round.windows_initial)
       << " -> " << EnergyPerWindow(round.energy_final["total"].get<double>(), round.windows_final)
       << " (" << round.windows_final << " windows)";
  if (round.guard.reverted_vertices > 0) {
    text << ", " << round.guard.reverted_vertices << " vertices taken back";
  }
  return text.str() + OutlinesText(round.terms);
}

std::vector<std::string> LevelTexts(const LevelSummary& level, bool crossings) {
  std::vector<std::string> lines;
  if (!level.reached_bound) lines.push_back(UnsplitText(level));
  if (level.remeshed_faces > 0 && !level.undone) lines.push_back(RemeshedText(level));
  if (level.left_out) {
    lines.push_back(LeftOutText(level));
  } else if (level.interrupted) {
    lines.push_back(InterruptedText(level));
  } else if (level.undone_vertices > 0) {
    lines.push_back(UndoneText(level));
  }
  if (crossings) lines.push_back(CrossingsText(level));
  return lines;
}

}  // namespace burin
