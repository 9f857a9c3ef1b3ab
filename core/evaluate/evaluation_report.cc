#include "core/evaluate/evaluation_report.h"

#include <cstdarg>
#include <cstdio>
#include <nlohmann/json.hpp>

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

// `reach`: the distance that the statistics are within. It stands beside every mean, with the share of
// the points that is within it.
std::string StatisticsLine(const char* name, const DistanceStatistics& statistics, double reach,
                           double unit) {
  if (statistics.matched == 0) {
    return Format("%-30s %10s %10s %10s %10.4g %9.2f %12lld\n", name, "-", "-", "-", reach / unit,
                  0.0, static_cast<long long>(statistics.count));
  }
  return Format("%-30s %10.4g %10.4g %10.4g %10.4g %9.2f %12lld\n", name, statistics.median / unit,
                statistics.mean / unit, statistics.rmse / unit, reach / unit,
                100 * statistics.MatchedShare(), static_cast<long long>(statistics.count));
}

std::string StatisticsHead(const char* within, const char* matched) {
  return Format("\n%-30s %10s %10s %10s %10s %9s %12s\n", "", "median", "mean", "RMSE", within,
                matched, "points");
}

nlohmann::json StatisticsJson(const DistanceStatistics& statistics, double reach) {
  return {{"median", statistics.median},   {"mean", statistics.mean},
          {"rmse", statistics.rmse},       {"count", statistics.count},
          {"matched", statistics.matched}, {"matched_share", statistics.MatchedShare()},
          {"max_distance", reach}};
}

// Of scale * rotation | translation.
nlohmann::json RowsOf(const Similarity& motion) {
  nlohmann::json rows = nlohmann::json::array();
  for (int r = 0; r < 3; ++r) {
    rows.push_back({motion.scale * motion.rotation(r, 0), motion.scale * motion.rotation(r, 1),
                    motion.scale * motion.rotation(r, 2), motion.translation[r]});
  }
  return rows;
}

std::string ShapeLines(const Evaluation& evaluation) {
  std::string lines = Format(
      "\nfacets: mean quality %.3f, %.2f %% with an angle under 10 degrees, %.2f %% over 150\n",
      evaluation.shape.quality, 100 * evaluation.shape.under_10_deg,
      100 * evaluation.shape.over_150_deg);
  if (evaluation.turned)
    lines += Format("turned: %.2f %% of the matched area faces away from the truth\n",
                    100 * *evaluation.turned);
  if (evaluation.truth_area > 0) {
    const double scale = evaluation.truth_from_mesh.scale;
    lines += Format("area: %.3f of the truth's\n",
                    scale * scale * evaluation.area / evaluation.truth_area);
  }
  return lines;
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
             NameOf(evaluation.distance).c_str(),
             evaluation.truth_is_mesh ? "surface point" : "truth point or surface point",
             evaluation.max_distance / unit);
  if (evaluation.zero_normals > 0) {
    report += Format(
        "normals: %lld of the truth's %lld are 0; to those points the point distance is "
        "measured\n",
        static_cast<long long>(evaluation.zero_normals),
        static_cast<long long>(evaluation.completeness.count));
  }
  const Similarity& motion = evaluation.truth_from_mesh;
  report += "alignment: " + NameOf(evaluation.align);
  if (evaluation.align != AlignmentKind::kNone) {
    report += Format(", %.4f deg, %.4g at the mesh's centre", motion.AngleDeg(),
                     evaluation.fit_shift / unit);
    if (evaluation.align != AlignmentKind::kRigid) report += Format(", scale %.8g", motion.scale);
    if (!evaluation.fit_converged) report += " (not converged)";
  }
  report += "\n" + StatisticsHead("within", "matched %");
  report += StatisticsLine("accuracy (mesh to truth)", evaluation.accuracy, evaluation.max_distance,
                           unit);
  report += StatisticsLine("completeness (truth to mesh)", evaluation.completeness,
                           evaluation.max_distance, unit);
  if (evaluation.grouped) {
    report += StatisticsLine("  near occlusion boundaries", evaluation.flagged,
                             evaluation.max_distance, unit);
    report += StatisticsLine("  the rest", evaluation.others, evaluation.max_distance, unit);
  }
  if (evaluation.other_distance) {
    const std::string other = NameOf(*evaluation.other_distance);
    report += StatisticsLine(("accuracy, " + other + " distance").c_str(),
                             evaluation.other_accuracy, evaluation.max_distance, unit);
    report += StatisticsLine(("completeness, " + other + " distance").c_str(),
                             evaluation.other_completeness, evaluation.max_distance, unit);
  }
  report += ShapeLines(evaluation);
  report += Format("\n%-30s %10s %10s %10s\n", "threshold", "precision", "recall", "F1");
  for (const ThresholdScore& score : evaluation.scores) {
    report += Format("%-30.6g %9.2f%% %9.2f%% %9.2f%%\n", score.tau / unit, 100 * score.precision,
                     100 * score.recall, 100 * score.f1);
  }
  if (evaluation.unmatched == UnmatchedSamples::kDrop)
    report += "(precision over matched samples only)\n";
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
  report += StatisticsHead("cap", "in cap %");
  report += StatisticsLine("accuracy (mesh to truth)", evaluation.accuracy, evaluation.cap, unit);
  report +=
      StatisticsLine("completeness (truth to mesh)", evaluation.completeness, evaluation.cap, unit);
  const std::optional<double> overall = evaluation.Overall();
  report += overall ? Format("%-30s %10s %10.4g\n", "mean of both", "", *overall / unit)
                    : "no point within the cap on one side at least\n";
  return report;
}

std::string DepthReport(const DepthEvaluation& evaluation, double unit) {
  const auto line = [unit](const std::string& name, const DepthErrors& errors) {
    return Format("%-30.200s %10.4g %10.4g %9.2f %12lld\n", name.c_str(), errors.Mae() / unit,
                  errors.Rmse() / unit, 100 * errors.CoveredShare(),
                  static_cast<long long>(errors.truth_pixels));
  };
  std::string report =
      "\nStrecha protocol: depth along the optical axis in the views of the scene\n";
  report += Format("\n%-30s %10s %10s %9s %12s\n", "view", "MAE", "RMSE", "covered %", "pixels");
  for (size_t k = 0; k < evaluation.views.size(); ++k) {
    report += line(evaluation.names[k], evaluation.views[k]);
  }
  report += line("all", evaluation.total);
  if (!(evaluation.sigma > 0)) return report;
  const DepthErrors& total = evaluation.total;
  const auto share = [&total](std::int64_t pixels) {
    return 100 * static_cast<double>(pixels) / static_cast<double>(total.truth_pixels);
  };
  report +=
      Format("\n%-30s %10s %10s\n", Format("|error|, sigma = %g", evaluation.sigma / unit).c_str(),
             "pixels %", "up to here");
  std::int64_t sum = 0;
  for (size_t k = 0; k < total.within_sigmas.size(); ++k) {
    sum += total.within_sigmas[k];
    report += Format("%-30s %9.2f%% %9.2f%%\n", Format("%zu to %zu sigma", k, k + 1).c_str(),
                     share(total.within_sigmas[k]), share(sum));
  }
  report += Format("%-30s %9.2f%%\n", "more than 10 sigma", share(total.beyond_sigmas));
  report += Format("%-30s %9.2f%%\n", "missing", share(total.MissingPixels()));
  return report;
}

std::string CameraReport(const CameraEvaluation& evaluation, double unit) {
  std::string report = Format(
      "\ncameras against the true ones, on surface points of the %s; RMS in pixels after a "
      "similarity "
      "(scale %.8g)\n",
      evaluation.on_truth ? "truth" : "mesh", evaluation.truth_from_scene.scale);
  report += Format("\n%-30s %10s %10s %10s %12s\n", "view", "error px", "centre", "deg", "points");
  for (const ViewCameraErrors& view : evaluation.views) {
    report += Format("%-30.200s ", view.name.c_str());
    report += view.points > 0 ? Format("%10.4g", view.px) : Format("%10s", "-");
    report +=
        Format(" %10.4g %10.4g %12d", view.center_distance / unit, view.angle_deg, view.points);
    report += view.behind > 0 ? Format(", %d behind\n", view.behind) : "\n";
  }
  const ViewCameraErrors& worst = evaluation.views[evaluation.worst];
  report += Format("%-30s %10.4g   worst: %.200s, %.4g\n", "all", evaluation.rms_px,
                   worst.name.c_str(), worst.px);
  const auto list = [&report](const char* head, const std::vector<std::string>& names) {
    if (names.empty()) return;
    report += head;
    for (size_t k = 0; k < names.size(); ++k) report += (k == 0 ? "" : ", ") + names[k];
    report += "\n";
  };
  list("only in the scene: ", evaluation.only_in_scene);
  list("only in the true model: ", evaluation.only_in_truth);
  return report;
}

nlohmann::json ToJson(const DtuEvaluation& evaluation) {
  nlohmann::json overall;  // null when one side has no point within the cap
  if (const std::optional<double> mean = evaluation.Overall()) overall = *mean;
  return {{"spacing", evaluation.spacing},
          {"cap", evaluation.cap},
          {"mesh_points", evaluation.mesh_points},
          {"truth_points", evaluation.truth_points},
          {"accuracy", StatisticsJson(evaluation.accuracy, evaluation.cap)},
          {"completeness", StatisticsJson(evaluation.completeness, evaluation.cap)},
          {"overall", overall}};
}

nlohmann::json ToJson(const DepthEvaluation& evaluation) {
  const auto errors_json = [&evaluation](const DepthErrors& errors) {
    nlohmann::json histogram;  // null without a sigma
    if (evaluation.sigma > 0) {
      histogram = {{"within_sigmas", errors.within_sigmas},
                   {"beyond", errors.beyond_sigmas},
                   {"missing", errors.MissingPixels()}};
    }
    return nlohmann::json{{"mae", errors.Mae()},
                          {"rmse", errors.Rmse()},
                          {"truth_pixels", errors.truth_pixels},
                          {"covered_pixels", errors.covered_pixels},
                          {"covered_share", errors.CoveredShare()},
                          {"histogram", histogram}};
  };
  nlohmann::json views = nlohmann::json::array();
  for (size_t k = 0; k < evaluation.views.size(); ++k) {
    nlohmann::json view = errors_json(evaluation.views[k]);
    view["name"] = evaluation.names[k];
    views.push_back(view);
  }
  nlohmann::json json = errors_json(evaluation.total);
  json["sigma"] = evaluation.sigma;
  json["views"] = views;
  return json;
}

nlohmann::json ToJson(const CameraEvaluation& evaluation) {
  nlohmann::json views = nlohmann::json::array();
  for (const ViewCameraErrors& view : evaluation.views) {
    nlohmann::json px;  // null without points
    if (view.points > 0) px = view.px;
    views.push_back({{"name", view.name},
                     {"px", px},
                     {"points", view.points},
                     {"behind", view.behind},
                     {"center_distance", view.center_distance},
                     {"angle_deg", view.angle_deg}});
  }
  return {{"surface", evaluation.on_truth ? "truth" : "mesh"},
          {"rms_px", evaluation.rms_px},
          {"views_with_points", evaluation.views_with_points},
          {"worst", evaluation.views[evaluation.worst].name},
          {"views", views},
          {"only_in_scene", evaluation.only_in_scene},
          {"only_in_truth", evaluation.only_in_truth},
          {"scale", evaluation.truth_from_scene.scale},
          {"truth_from_scene", RowsOf(evaluation.truth_from_scene)}};
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
  if (evaluation.align != AlignmentKind::kNone) {
    const Similarity& motion = evaluation.truth_from_mesh;
    alignment = {{"kind", NameOf(evaluation.align)},
                 {"truth_from_mesh", RowsOf(motion)},
                 {"scale", motion.scale},
                 {"angle_deg", motion.AngleDeg()},
                 {"shift_at_centre", evaluation.fit_shift},
                 {"converged", evaluation.fit_converged}};
  }
  nlohmann::json other;  // null for a truth without normals
  if (evaluation.other_distance) {
    other = {
        {"distance", NameOf(*evaluation.other_distance)},
        {"accuracy", StatisticsJson(evaluation.other_accuracy, evaluation.max_distance)},
        {"completeness", StatisticsJson(evaluation.other_completeness, evaluation.max_distance)}};
  }
  nlohmann::json truth_area;  // null for a cloud
  if (evaluation.truth_is_mesh) truth_area = evaluation.truth_area;
  nlohmann::json turned;  // null where no normal says so
  if (evaluation.turned) turned = *evaluation.turned;
  nlohmann::json boundary;  // null without flags
  if (evaluation.grouped) {
    boundary = {{"near", StatisticsJson(evaluation.flagged, evaluation.max_distance)},
                {"rest", StatisticsJson(evaluation.others, evaluation.max_distance)},
                {"near_recall", evaluation.flagged_recall},
                {"rest_recall", evaluation.others_recall}};
  }
  return {{"mesh",
           {{"vertices", evaluation.vertex_count},
            {"faces", evaluation.face_count},
            {"area", evaluation.area},
            {"quality", evaluation.shape.quality},
            {"under_10_deg", evaluation.shape.under_10_deg},
            {"over_150_deg", evaluation.shape.over_150_deg}}},
          {"truth_area", truth_area},
          {"turned", turned},
          {"truth", evaluation.truth_is_mesh ? "mesh" : "cloud"},
          {"distance", NameOf(evaluation.distance)},
          {"unmatched", NameOf(evaluation.unmatched)},
          {"zero_normals", evaluation.zero_normals},
          {"unit", evaluation.unit},
          {"max_distance", evaluation.max_distance},
          {"alignment", alignment},
          {"accuracy", StatisticsJson(evaluation.accuracy, evaluation.max_distance)},
          {"completeness", StatisticsJson(evaluation.completeness, evaluation.max_distance)},
          {"other_distance", other},
          {"boundary", boundary},
          {"scores", scores}};
}

}  // namespace burin
