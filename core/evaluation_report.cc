#include "core/evaluation_report.h"

#include <cstdarg>
#include <cstdio>

namespace burin {
namespace {

// printf into a string.
__attribute__((format(printf, 1, 2))) std::string Format(const char* format, ...) {
  char buffer[512];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(buffer, sizeof(buffer), format, arguments);
  va_end(arguments);
  return buffer;
}

std::string StatisticsLine(const char* name, const DistanceStatistics& statistics, double unit) {
  return Format("%-30s %10.4g %10.4g %10.4g %9.2f %12lld\n", name, statistics.median / unit,
                statistics.mean / unit, statistics.rmse / unit, 100 * statistics.MatchedShare(),
                static_cast<long long>(statistics.count));
}

std::string StatisticsHead(const char* matched) {
  return Format("\n%-30s %10s %10s %10s %9s %12s\n", "", "median", "mean", "RMSE", matched,
                "points");
}

nlohmann::json StatisticsJson(const DistanceStatistics& statistics) {
  return {{"median", statistics.median},   {"mean", statistics.mean},
          {"rmse", statistics.rmse},       {"count", statistics.count},
          {"matched", statistics.matched}, {"matched_share", statistics.MatchedShare()}};
}

}  // namespace

std::string EvaluationReport(const Evaluation& evaluation) {
  const double unit = evaluation.unit;
  std::string report =
      Format("mesh: %lld vertices, %lld faces; truth: %s; lengths below in %g world units\n",
             static_cast<long long>(evaluation.vertex_count),
             static_cast<long long>(evaluation.face_count),
             evaluation.truth_is_mesh ? "mesh" : "point cloud", unit);
  report +=
      Format("measured: %s distance to the nearest %s; points further than %g are unmatched\n",
             evaluation.distance.c_str(),
             evaluation.truth_is_mesh ? "surface point" : "truth point or surface point",
             evaluation.max_distance / unit);
  const Similarity& motion = evaluation.truth_from_mesh;
  report += "alignment: " + evaluation.align;
  if (evaluation.align != "none") {
    report += Format(", %.4f deg, %.4g at the mesh's centre", motion.AngleDeg(),
                     evaluation.fit_shift / unit);
    if (evaluation.align == "similarity") report += Format(", scale %.8g", motion.scale);
    if (!evaluation.fit_converged) report += " (not converged)";
  }
  report += "\n" + StatisticsHead("matched %");
  report += StatisticsLine("accuracy (mesh to truth)", evaluation.accuracy, unit);
  report += StatisticsLine("completeness (truth to mesh)", evaluation.completeness, unit);
  if (evaluation.grouped) {
    report += StatisticsLine("  near occlusion boundaries", evaluation.flagged, unit);
    report += StatisticsLine("  the rest", evaluation.others, unit);
  }
  if (!evaluation.other_distance.empty()) {
    const std::string& other = evaluation.other_distance;
    report += StatisticsLine(("accuracy, " + other + " distance").c_str(),
                             evaluation.other_accuracy, unit);
    report += StatisticsLine(("completeness, " + other + " distance").c_str(),
                             evaluation.other_completeness, unit);
  }
  report += Format("\n%-30s %10s %10s %10s\n", "threshold", "precision", "recall", "F1");
  for (const ThresholdScore& score : evaluation.scores) {
    report += Format("%-30.6g %9.2f%% %9.2f%% %9.2f%%\n", score.tau / unit, 100 * score.precision,
                     100 * score.recall, 100 * score.f1);
  }
  if (evaluation.unmatched == "drop") report += "(precision over matched samples only)\n";
  return report;
}

std::string DtuReport(const DtuEvaluation& evaluation, double unit) {
  std::string report = Format(
      "\nDTU protocol: point to point, %lld points of the mesh, %lld of the truth, %g apart; "
      "points "
      "further than %g are left out\n",
      static_cast<long long>(evaluation.mesh_points),
      static_cast<long long>(evaluation.truth_points), evaluation.spacing / unit,
      evaluation.cap / unit);
  report += StatisticsHead("in cap %");
  report += StatisticsLine("accuracy (mesh to truth)", evaluation.accuracy, unit);
  report += StatisticsLine("completeness (truth to mesh)", evaluation.completeness, unit);
  const std::optional<double> overall = evaluation.Overall();
  report += overall ? Format("%-30s %10s %10.4g\n", "mean of both", "", *overall / unit)
                    : "no point within the cap on one side at least\n";
  return report;
}

nlohmann::json ToJson(const DtuEvaluation& evaluation) {
  nlohmann::json overall;  // null when one side has no point within the cap
  if (const std::optional<double> mean = evaluation.Overall()) overall = *mean;
  return {{"spacing", evaluation.spacing},
          {"cap", evaluation.cap},
          {"mesh_points", evaluation.mesh_points},
          {"truth_points", evaluation.truth_points},
          {"accuracy", StatisticsJson(evaluation.accuracy)},
          {"completeness", StatisticsJson(evaluation.completeness)},
          {"overall", overall}};
}

nlohmann::json ToJson(const Evaluation& evaluation) {
  nlohmann::json scores = nlohmann::json::array();
  for (const ThresholdScore& score : evaluation.scores) {
    scores.push_back({{"tau", score.tau},
                      {"precision", score.precision},
                      {"recall", score.recall},
                      {"f1", score.f1}});
  }
  nlohmann::json alignment;  // null without one
  if (evaluation.align != "none") {
    const Similarity& motion = evaluation.truth_from_mesh;
    nlohmann::json rows = nlohmann::json::array();  // of scale * rotation | translation
    for (int r = 0; r < 3; ++r) {
      rows.push_back({motion.scale * motion.rotation(r, 0), motion.scale * motion.rotation(r, 1),
                      motion.scale * motion.rotation(r, 2), motion.translation[r]});
    }
    alignment = {{"kind", evaluation.align},
                 {"truth_from_mesh", rows},
                 {"scale", motion.scale},
                 {"angle_deg", motion.AngleDeg()},
                 {"shift_at_centre", evaluation.fit_shift},
                 {"converged", evaluation.fit_converged}};
  }
  nlohmann::json other;  // null for a truth without normals
  if (!evaluation.other_distance.empty()) {
    other = {{"distance", evaluation.other_distance},
             {"accuracy", StatisticsJson(evaluation.other_accuracy)},
             {"completeness", StatisticsJson(evaluation.other_completeness)}};
  }
  nlohmann::json boundary;  // null without flags
  if (evaluation.grouped) {
    boundary = {{"near", StatisticsJson(evaluation.flagged)},
                {"rest", StatisticsJson(evaluation.others)},
                {"near_recall", evaluation.flagged_recall},
                {"rest_recall", evaluation.others_recall}};
  }
  return {{"mesh",
           {{"vertices", evaluation.vertex_count},
            {"faces", evaluation.face_count},
            {"area", evaluation.area}}},
          {"truth", evaluation.truth_is_mesh ? "mesh" : "cloud"},
          {"distance", evaluation.distance},
          {"unmatched", evaluation.unmatched},
          {"unit", evaluation.unit},
          {"max_distance", evaluation.max_distance},
          {"alignment", alignment},
          {"accuracy", StatisticsJson(evaluation.accuracy)},
          {"completeness", StatisticsJson(evaluation.completeness)},
          {"other_distance", other},
          {"boundary", boundary},
          {"scores", scores}};
}

}  // namespace burin
