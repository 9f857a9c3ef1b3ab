#include "apps/run/verdict_output.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/support/fixed_text.h"
#include "core/support/json_file.h"

namespace burin {
namespace {

using nlohmann::ordered_json;

ordered_json EvidenceJson(const Evidence& evidence) {
  return {{"windows", evidence.windows},
          {"E", RoundedOrNull(evidence.on_line)},
          {"A", RoundedOrNull(evidence.at_place)},
          {"px", RoundedOrNull(evidence.noise_px)}};
}

std::string Figure(double value) { return std::isfinite(value) ? Fixed(value, 2) : "-"; }

void AddRow(const std::string& name, const Evidence& evidence, const std::string& remark,
            size_t width, std::ostringstream* text) {
  *text << std::left << std::setw(static_cast<int>(width)) << name << std::right << std::setw(9)
        << evidence.windows << std::setw(7) << Figure(evidence.on_line) << std::setw(7)
        << Figure(evidence.at_place) << std::setw(7) << Figure(evidence.noise_px) << remark << "\n";
}

}  // namespace

ordered_json VerdictJson(const SceneVerdict& verdict, const Scene& scene,
                         const std::vector<std::string>& left_out) {
  ordered_json json;
  json["verdict"] = NameOf(verdict.verdict);
  json["reason"] = verdict.reason;
  json.update(EvidenceJson(verdict.evidence));
  json["pairs"] = verdict.pairs;
  ordered_json misfits = ordered_json::array();
  for (const int view : verdict.misfits) misfits.push_back(scene.views[view].name);
  json["misfits"] = misfits;
  json["left_out"] = left_out;
  json["views"] = ordered_json::array();
  for (size_t v = 0; v < verdict.views.size(); ++v) {
    ordered_json view = {{"name", scene.views[v].name}};
    view.update(EvidenceJson(verdict.views[v].evidence));
    view["misfit"] = verdict.views[v].misfit;
    view["track_px"] = RoundedOrNull(verdict.tracks.median_px[v]);
    json["views"].push_back(view);
  }
  return json;
}

ordered_json CheckJson(const SceneVerdict& verdict, const Scene& scene, const MeshParts& parts) {
  ordered_json json = VerdictJson(verdict, scene, {});
  json["parts"] = PartsJson(parts);
  return json;
}

std::string VerdictText(const SceneVerdict& verdict, const Scene& scene) {
  size_t width = 10;
  for (const View& view : scene.views) width = std::max(width, view.name.size());
  std::ostringstream text;
  text << NameOf(verdict.verdict) << (verdict.reason.empty() ? "" : ": " + verdict.reason) << "\n"
       << std::left << std::setw(static_cast<int>(width)) << ""
       << "  windows      E      A     px\n";
  AddRow("all", verdict.evidence, "", width, &text);
  for (size_t v = 0; v < verdict.views.size(); ++v) {
    std::string remark = verdict.views[v].misfit ? "  does not fit" : "";
    const std::vector<int>& off = verdict.tracks.off;
    if (std::find(off.begin(), off.end(), static_cast<int>(v)) != off.end()) {
      const double px = verdict.tracks.median_px[v];
      remark += "  sparse points " + (std::isfinite(px) ? Fixed(px, 1) + " px off" : "behind it");
    }
    AddRow(scene.views[v].name, verdict.views[v].evidence, remark, width, &text);
  }
  return text.str();
}

}  // namespace burin
