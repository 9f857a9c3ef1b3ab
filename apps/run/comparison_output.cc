#include "apps/run/comparison_output.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/evaluate/evaluation_report.h"
#include "core/image/svg_chart.h"

namespace burin {
namespace {

constexpr double kLogFrom =
    4;  // ratio of largest to smallest value from which an axis is logarithmic

double EnergyOf(const nlohmann::json& by_term) { return by_term["total"].get<double>(); }

std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c == '\n' || c == '\r' ? ' ' : c;
  }
  return quoted + "\"";
}

// JSON has no NaN; null stands for "not measured".
nlohmann::ordered_json OrNull(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
}

// The lowest energy that a strategy ended the round with.
double BestEnergy(const Comparison& comparison, int level, int round) {
  double best = std::numeric_limits<double>::infinity();
  for (const ComparedStrategy& strategy : comparison.strategies) {
    for (const ComparedRound& one : strategy.rounds) {
      if (one.level != level || one.round != round || !one.reason.empty()) continue;
      best = std::min(best, EnergyOf(one.trial.energy_final));
    }
  }
  return best;
}

nlohmann::ordered_json RoundJson(const ComparedRound& round) {
  nlohmann::ordered_json json;
  json["level"] = round.level;
  json["round"] = round.round;
  json["image"] = {round.width, round.height};
  json["vertices"] = round.vertices;
  json["faces"] = round.faces;
  json["unknowns"] = round.unknowns;
  json["reason"] = round.reason;
  if (!round.reason.empty()) return json;
  json["termination"] = round.trial.solve.termination;
  json["iterations"] = round.trial.solve.iterations;
  json["evaluations"] = round.trial.evaluations;
  json["seconds"] = round.trial.seconds;
  json["linear_solver_seconds"] = round.trial.solve.linear_solver_seconds;
  json["energy_initial"] = round.trial.energy_initial;
  json["energy_final"] = round.trial.energy_final;
  json["rmse_initial"] = OrNull(round.rmse_start);
  json["rmse_final"] = OrNull(round.rmse);
  return json;
}

std::string Padded(const std::string& text, size_t width) {
  return text.size() < width ? std::string(width - text.size(), ' ') + text : text;
}

std::string Formatted(const char* format, double value) {
  if (!std::isfinite(value)) return "-";
  char text[48];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

// The four panels over the rows that `wanted` takes.
template <typename Wanted>
ChartPage Page(const Comparison& comparison, const Wanted& wanted) {
  ChartPage page;
  std::vector<ChartSeries> series[4];
  for (const ComparedStrategy& strategy : comparison.strategies) {
    ChartSeries curves[4];
    for (const ComparisonRow& row : comparison.rows) {
      if (row.strategy != strategy.name || !wanted(row)) continue;
      for (int k = 0; k < 4; ++k) {
        curves[k].x.push_back(k % 2 == 0 ? static_cast<double>(row.evaluations) : row.seconds);
        curves[k].y.push_back(k < 2 ? row.energy : row.rmse);
      }
    }
    if (curves[0].x.empty()) continue;
    for (int k = 0; k < 4; ++k) {
      curves[k].style = page.names.size();
      series[k].push_back(curves[k]);
    }
    page.names.push_back(strategy.name);
  }
  for (int k = 0; k < (comparison.has_truth ? 4 : 2); ++k) {
    ChartPanel panel;
    panel.x_label = k % 2 == 0 ? "evaluations" : "seconds of solving";
    panel.y_label = k < 2 ? "energy" : "RMSE to truth, world units";
    panel.log_x = WantsLogAxis(series[k], true, kLogFrom);
    panel.log_y = WantsLogAxis(series[k], false, kLogFrom);
    panel.series = series[k];
    page.panels.push_back(panel);
  }
  return page;
}

// A strategy that rises far above the start that all share would flatten the others' curves.
void CutFarAboveTheStart(ChartPanel* panel) {
  double start = std::numeric_limits<double>::quiet_NaN();
  double lowest = std::numeric_limits<double>::infinity();
  for (const ChartSeries& series : panel->series) {
    for (const double y : series.y) {
      if (!std::isfinite(y)) continue;
      if (!std::isfinite(start)) start = y;
      lowest = std::min(lowest, y);
    }
  }
  if (!(lowest < start)) return;
  panel->max_y = start + 0.5 * (start - lowest);
  if (panel->max_y < kLogFrom * lowest) panel->log_y = false;
}

ChartPage RoundPage(const Comparison& comparison, const ComparedRound& round) {
  ChartPage page = Page(comparison, [&](const ComparisonRow& row) {
    return row.level == round.level && row.round == round.round;
  });
  page.title = "Strategies on one frozen round: level " + std::to_string(round.level) + " (" +
               std::to_string(round.width) + "x" + std::to_string(round.height) + "), round " +
               std::to_string(round.round + 1);
  page.subtitle = std::to_string(round.faces) + " faces, " + std::to_string(round.unknowns) +
                  " unknowns, " + std::to_string(comparison.selection.pairs.size()) +
                  " pairs; the same vertices at the start; a mark an iteration";
  for (ChartPanel& panel : page.panels) CutFarAboveTheStart(&panel);
  return page;
}

}  // namespace

std::string ComparisonCsv(const Comparison& comparison) {
  std::ostringstream csv;
  csv.precision(12);
  csv << "strategy,level,round,iteration,evaluations,seconds,energy,rmse,accepted,note\n";
  for (const ComparisonRow& row : comparison.rows) {
    csv << row.strategy << ',' << row.level << ',' << row.round << ',' << row.iteration << ','
        << row.evaluations << ',' << Formatted("%.6f", row.seconds) << ',' << row.energy << ',';
    if (std::isfinite(row.rmse)) csv << row.rmse;
    csv << ',' << (row.accepted ? 1 : 0) << ",\n";
  }
  for (const ComparedStrategy& strategy : comparison.strategies) {
    for (const ComparedRound& round : strategy.rounds) {
      if (round.reason.empty()) continue;
      csv << strategy.name << ',' << round.level << ',' << round.round << ",,,,,,,"
          << Quoted(round.reason) << '\n';
    }
    if (!strategy.reason.empty()) {
      csv << strategy.name << ",,,,,,,,," << Quoted(strategy.reason) << '\n';
    }
  }
  return csv.str();
}

StrategyTotals TotalsOf(const Comparison& comparison, const ComparedStrategy& strategy) {
  StrategyTotals totals;
  totals.reason = strategy.reason;
  int solved = 0;
  int shares = 0;
  double share_sum = 0;
  for (const ComparedRound& round : strategy.rounds) {
    if (!round.reason.empty()) {
      if (totals.reason.empty()) totals.reason = round.reason;
      continue;
    }
    ++solved;
    totals.energy_initial = EnergyOf(round.trial.energy_initial);
    totals.energy_final = EnergyOf(round.trial.energy_final);
    totals.rmse = round.rmse;
    totals.seconds += round.trial.seconds;
    totals.iterations += round.trial.solve.iterations;
    totals.evaluations += round.trial.evaluations;
    if (comparison.options.mode == "whole") continue;
    const double possible =
        totals.energy_initial - BestEnergy(comparison, round.level, round.round);
    if (!(possible > 0)) continue;
    share_sum += (totals.energy_initial - totals.energy_final) / possible;
    ++shares;
  }
  if (shares > 0) totals.reduction_share = share_sum / shares;
  if (totals.reason.empty()) {
    totals.status = "ok";
  } else if (solved > 0) {
    totals.status = "partly";
  } else {
    totals.status = totals.reason.rfind("refused", 0) == 0 ? "refused" : "failed";
  }
  return totals;
}

nlohmann::ordered_json ComparisonJson(const Comparison& comparison) {
  nlohmann::ordered_json json;
  json["mode"] = comparison.options.mode;
  json["reference_by_round"] = comparison.references;
  json["pairs"] = {{"method", comparison.selection.recipe.method},
                   {"count", comparison.selection.pairs.size()}};
  if (comparison.has_truth) json["before"] = ToJson(comparison.before);
  json["strategies"] = nlohmann::ordered_json::array();
  for (const ComparedStrategy& strategy : comparison.strategies) {
    const StrategyTotals totals = TotalsOf(comparison, strategy);
    nlohmann::ordered_json entry;
    entry["strategy"] = strategy.name;
    entry["status"] = totals.status;
    entry["reason"] = totals.reason;
    entry["energy_initial"] = OrNull(totals.energy_initial);
    entry["energy_final"] = OrNull(totals.energy_final);
    entry["rmse_final"] = OrNull(totals.rmse);
    entry["seconds"] = totals.seconds;
    entry["iterations"] = totals.iterations;
    entry["evaluations"] = totals.evaluations;
    entry["reduction_share"] = OrNull(totals.reduction_share);
    entry["faces"] = strategy.rounds.empty() ? 0 : strategy.rounds.back().faces;
    entry["termination"] =
        strategy.rounds.empty() ? "" : strategy.rounds.back().trial.solve.termination;
    if (strategy.evaluated) entry["evaluation"] = ToJson(strategy.evaluation);
    entry["rounds"] = nlohmann::ordered_json::array();
    for (const ComparedRound& round : strategy.rounds) entry["rounds"].push_back(RoundJson(round));
    json["strategies"].push_back(std::move(entry));
  }
  return json;
}

std::string ComparisonTable(const Comparison& comparison) {
  const bool frozen = comparison.options.mode == "frozen";
  size_t width = 8;
  for (const ComparedStrategy& strategy : comparison.strategies) {
    width = std::max(width, strategy.name.size());
  }
  std::string table =
      "strategy" + std::string(width - 8, ' ') +
      "          energy, last round        RMSE    seconds  iterations  evaluations" +
      (frozen ? "  of best reduction" : "") + "\n";
  for (const ComparedStrategy& strategy : comparison.strategies) {
    const StrategyTotals totals = TotalsOf(comparison, strategy);
    table += strategy.name + std::string(width - strategy.name.size(), ' ');
    if (totals.status != "refused" && totals.status != "failed") {
      table += Padded(Formatted("%.6g", totals.energy_initial) + " -> " +
                          Formatted("%.6g", totals.energy_final),
                      28) +
               Padded(Formatted("%.4g", totals.rmse), 12) +
               Padded(Formatted("%.2f", totals.seconds), 11) +
               Padded(std::to_string(totals.iterations), 12) +
               Padded(std::to_string(totals.evaluations), 13);
      if (frozen) table += Padded(Formatted("%.1f %%", 100 * totals.reduction_share), 19);
    }
    if (!totals.reason.empty()) table += "  " + totals.reason;
    table += "\n";
  }
  return table;
}

std::vector<NamedChart> ComparisonCharts(const Comparison& comparison) {
  if (comparison.options.mode == "whole") {
    ChartPage page = Page(comparison, [](const ComparisonRow&) { return true; });
    page.title = "Whole runs of each strategy";
    page.subtitle =
        "energies of different rounds and strategies do not compare (own visibility); " +
        std::to_string(comparison.selection.pairs.size()) + " pairs";
    return {{"compare.svg", SvgText(page)}};
  }
  std::vector<NamedChart> charts;
  double largest = -1;
  std::string main_chart;
  for (size_t r = 0; r < comparison.strategies.front().rounds.size(); ++r) {
    const ComparedRound* solved = nullptr;
    for (const ComparedStrategy& strategy : comparison.strategies) {
      if (strategy.rounds[r].reason.empty()) solved = &strategy.rounds[r];
    }
    if (solved == nullptr) continue;
    const std::string name = "rounds/level" + std::to_string(solved->level) + "_round" +
                             std::to_string(solved->round) + ".svg";
    charts.push_back({name, SvgText(RoundPage(comparison, *solved))});
    const double start = EnergyOf(solved->trial.energy_initial);
    const double share =
        start > 0 ? 1 - BestEnergy(comparison, solved->level, solved->round) / start : 0;
    if (share > largest) {
      largest = share;
      main_chart = charts.back().svg;
    }
  }
  if (!charts.empty()) charts.insert(charts.begin(), NamedChart{"compare.svg", main_chart});
  return charts;
}

}  // namespace burin
