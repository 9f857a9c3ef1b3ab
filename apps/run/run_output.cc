#include "apps/run/run_output.h"

#include <ceres/version.h>
#include <embree3/rtcore.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/core/version.hpp>
#include <sstream>

#include "apps/run/cameras_output.h"
#include "apps/run/free_space_output.h"
#include "core/scene/doubts.h"
#include "core/support/fixed_text.h"
#include "core/support/parallel.h"
#include "costs/pair_kernel.h"

namespace burin {
namespace {

// By term, of sums over this many windows; null where there is none.
nlohmann::json PerWindow(nlohmann::json energies, int64_t windows) {
  for (auto& [term, energy] : energies.items()) {
    energy = windows > 0 ? nlohmann::json(energy.get<double>() / static_cast<double>(windows))
                         : nlohmann::json();
  }
  return energies;
}

nlohmann::ordered_json RoundJson(const RoundSummary& round) {
  nlohmann::ordered_json json;
  json["round"] = round.round;
  json["strategy"] = round.solve.strategy;
  json["termination"] = round.solve.termination;
  json["iterations"] = round.solve.iterations;
  json["unknowns"] = round.solve.unknowns;
  json["pair_pixels"] = round.pair_pixels;
  json["supported_vertices"] = round.supported_vertices;
  json["relaxed_vertices"] = round.relaxed_vertices;
  json["carried_vertices"] = round.carried_vertices;
  json["camera_px"] = round.camera_px;
  json["guard"] = {{"inverted_facets", round.guard.inverted_facets},
                   {"stretched_edges", round.guard.stretched_edges},
                   {"far_vertices", round.guard.far_vertices},
                   {"reverted_vertices", round.guard.reverted_vertices}};
  json["crossings"] = {{"found", round.crossings.found},
                       {"left", round.crossings.left},
                       {"taken_back", round.crossings.taken_back}};
  json["energy_initial"] = round.energy_initial;
  json["energy_final"] = round.energy_final;
  json["windows_initial"] = round.windows_initial;
  json["windows_final"] = round.windows_final;
  json["energy_per_window_initial"] = PerWindow(round.energy_initial, round.windows_initial);
  json["energy_per_window_final"] = PerWindow(round.energy_final, round.windows_final);
  json["terms"] = round.terms;
  json["seconds"] = {{"visibility", round.visibility_seconds},
                     {"build", round.build_seconds},
                     {"solve", round.solve_seconds},
                     {"linear_solver", round.solve.linear_solver_seconds}};
  return json;
}

}  // namespace

nlohmann::ordered_json OptionsJson(const OptionSet& set) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const Option& option : set.options()) {
    option.Visit([&](const auto& value) { json[option.name] = value; });
  }
  return json;
}

nlohmann::ordered_json VersionsJson() {
  return {
      {"burin", "0.1.0"},
      {"ceres", CERES_VERSION_STRING},
      {"eigen", std::to_string(EIGEN_WORLD_VERSION) + "." + std::to_string(EIGEN_MAJOR_VERSION) +
                    "." + std::to_string(EIGEN_MINOR_VERSION)},
      {"opencv", CV_VERSION},
      {"embree", RTC_VERSION_STRING},
      {"compiler", __VERSION__}};
}

double PeakMemoryMib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

void CloseParts(const TriangleMesh& input, PipelineResult* result, MeshParts* parts) {
  if (!result->closing.has_value()) return;
  MarkSeenByPairs(input, result->seen_with_part, parts);
  ClosingFigures& closing = *result->closing;
  closing.parts = static_cast<int>(parts->parts.size());
  for (const MeshPart& part : parts->parts) {
    if (part.seen_by_pair.value_or(true)) continue;
    ++closing.parts_out;
    closing.parts_out_area += part.area_share;
  }
}

nlohmann::ordered_json SummaryJson(const RunInputs& inputs, const PipelineOptions& options,
                                   const PipelineResult& result, double total_seconds) {
  nlohmann::ordered_json json;
  json["command"] = inputs.command_line;
  json["versions"] = VersionsJson();
  PipelineOptions described = options;
  OptionSet set;
  described.Describe(&set);
  json["options"] = OptionsJson(set);
  json["input"] = {{"scene", inputs.scene_path},
                   {"mesh", inputs.mesh_path},
                   {"mesh_checks", inputs.mesh_report},
                   {"views", inputs.scene->views.size()},
                   {"points", inputs.scene->points.size()},
                   {"doubts", DoubtsAbout(*inputs.scene)},
                   {"vertices", inputs.mesh->vertices.size()},
                   {"faces", inputs.mesh->faces.size()}};
  json["parts"] = PartsJson(inputs.parts);
  json["verdict"] = inputs.verdict.empty() ? nlohmann::ordered_json()
                                           : nlohmann::ordered_json::parse(inputs.verdict);
  if (options.refinement.cameras.refine != CameraUnknowns::kNone) {
    const Scene& used = inputs.used != nullptr ? *inputs.used : *inputs.scene;
    nlohmann::ordered_json& cameras = json["cameras"];
    cameras["tracks"] = nullptr;
    if (result.by_tracks.has_value()) {
      cameras["tracks"] = TrackStepJson(*result.by_tracks, used);
    } else if (!inputs.cameras.empty()) {
      cameras["tracks"] = nlohmann::ordered_json::parse(inputs.cameras);
    }
    if (!result.refinement.cameras.empty()) {
      cameras["moved"] = MovedJson(used, *inputs.mesh, result.refinement.cameras);
      cameras["sparse_points"] =
          SparsePointsJson(used, result.SeenOr(used), result.refinement.cameras);
    }
  }
  json["closing"] = result.closing.has_value() ? ClosingJson(*result.closing) : nullptr;
  json["free_space"] = FreeSpaceJson(result.free_space);
  json["trim"] = result.trimming.has_value() ? TrimJson(*result.trimming) : nullptr;
  json["output"] = {{"vertices", result.mesh.vertices.size()},
                    {"faces", result.mesh.faces.size()},
                    {"footprint", result.refinement.footprint}};
  std::vector<std::string> left_out;
  if (!json["verdict"].is_null()) left_out = json["verdict"]["left_out"];
  std::vector<std::string> names;  // of the views that are left
  for (const View& view : inputs.scene->views) {
    if (std::find(left_out.begin(), left_out.end(), view.name) == left_out.end()) {
      names.push_back(view.name);
    }
  }
  nlohmann::ordered_json pairs = nlohmann::ordered_json::array();
  for (const CameraPair& pair : result.selection.pairs) {
    pairs.push_back({names[pair.reference], names[pair.second]});
  }
  json["pairs"] = {{"method", NameOf(result.selection.recipe.method)},
                   {"count", result.selection.pairs.size()},
                   {"without_partner", result.selection.warnings},
                   {"list", pairs}};
  nlohmann::ordered_json levels = nlohmann::ordered_json::array();
  int64_t evaluations = 0;
  int iterations = 0;
  for (const LevelSummary& level : result.refinement.levels) {
    nlohmann::ordered_json entry;
    entry["level"] = level.level;
    entry["image"] = {level.width, level.height};
    entry["views"] = {{"taking_part", level.views}, {"halved_less", level.views_halved_less}};
    entry["vertices"] = level.vertices;
    entry["faces"] = level.faces;
    entry["reached_bound"] = level.reached_bound;
    entry["remeshed_faces"] = level.remeshed_faces;
    entry["seconds"] = {{"images", level.image_seconds},
                        {"subdivide", level.subdivide_seconds},
                        {"remesh", level.remesh_seconds}};
    entry["held_back"] = level.held_back;
    entry["left_out"] = level.left_out;
    entry["undone"] = level.undone;
    entry["undone_vertices"] = level.undone_vertices;
    entry["crossings"] = {{"before", level.crossing_facets.before},
                          {"after", level.crossing_facets.after},
                          {"taken_back", level.TakenBack()}};
    entry["back_faces"] = {{"before", level.back_faces.before}, {"after", level.back_faces.after}};
    entry["interrupted"] = level.interrupted;
    entry["rounds"] = nlohmann::ordered_json::array();
    for (const RoundSummary& round : level.rounds) {
      entry["rounds"].push_back(RoundJson(round));
      iterations += round.solve.iterations;
      if (round.terms.contains("photometric")) {
        evaluations += round.terms["photometric"]["evaluations"].get<int64_t>();
      }
    }
    levels.push_back(std::move(entry));
  }
  json["levels"] = levels;
  json["iterations"] = iterations;
  json["evaluations"] = evaluations;
  json["seconds"] = {{"load", inputs.load_seconds},
                     {"pairs", result.selection_seconds},
                     {"verdict", inputs.verdict_seconds},
                     {"free_space", result.free_space_seconds},
                     {"refine", result.refinement.seconds},
                     {"surface", result.surface_seconds},
                     {"total", total_seconds}};
  json["instruction_set"] = KernelInstructionSet();
  json["threads"] = ThreadsFor(options.threads);
  json["peak_memory_mib"] = std::round(PeakMemoryMib());
  json["memory"] = MemoryJson(inputs.memory);
  const bool any_round =
      !result.refinement.levels.empty() && !result.refinement.levels.back().rounds.empty();
  json["termination"] =
      any_round ? result.refinement.levels.back().rounds.back().solve.termination : "No round ran.";
  return json;
}

void WriteSurface(const std::filesystem::path& folder, const PipelineResult& result) {
  WriteMesh(folder / "refined.ply", result.mesh, nullptr, result.quality);
  if (result.trimming.has_value()) {
    WriteMesh(folder / "whole.ply", result.trimming->whole, nullptr, result.trimming->quality);
  } else {
    std::filesystem::remove(folder / "whole.ply");
  }
}

std::string TraceCsv(const std::vector<RefinementEvent>& events) {
  std::ostringstream csv;
  csv << "level,round,iteration,energy,gradient_max,step_norm,accepted,linear_iterations,seconds\n";
  csv.precision(12);
  for (const RefinementEvent& event : events) {
    const IterationRecord& record = event.iteration;
    csv << event.level << ',' << event.round << ',' << record.iteration << ',' << record.energy
        << ',' << record.gradient_max << ',' << record.step_norm << ',' << (record.accepted ? 1 : 0)
        << ',' << record.linear_iterations << ',' << Fixed(record.seconds, 4) << '\n';
  }
  return csv.str();
}

}  // namespace burin
