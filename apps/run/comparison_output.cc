#include "apps/run/comparison_output.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <utility>

#include "core/evaluate/evaluation_report.h"

namespace burin {
namespace {

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
  json["cameras"] = round.cameras;
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
  if (round.cameras > 0) json["camera_px"] = round.trial.camera_px;
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

const ComparedRound* FindRound(const ComparedStrategy& strategy, int level, int round) {
  for (const ComparedRound& one : strategy.rounds) {
    if (one.level == level && one.round == round) return &one;
  }
  return nullptr;
}

// The fields from `width` to `pairs`; sizes are empty where there is no such round.
std::string SizeFields(const Comparison& comparison, const ComparedRound* round) {
  std::ostringstream fields;
  if (round == nullptr) {
    fields << ",,,,";
  } else {
    fields << round->width << ',' << round->height << ',' << round->faces << ',' << round->unknowns
           << ',' << round->cameras;
  }
  fields << ',' << comparison.selection.pairs.size();
  return fields.str();
}

}  // namespace

std::string ComparisonCsv(const Comparison& comparison) {
  std::ostringstream csv;
  csv.precision(12);
  csv << "mode,strategy,level,round,width,height,faces,unknowns,cameras,pairs,iteration,"
         "evaluations,"
         "seconds,energy,rmse,camera_px,accepted,note\n";
  const std::string mode = NameOf(comparison.options.mode);
  for (const ComparedStrategy& strategy : comparison.strategies) {
    for (const ComparisonRow& row : comparison.rows) {
      if (row.strategy != strategy.name) continue;
      csv << mode << ',' << row.strategy << ',' << row.level << ',' << row.round << ','
          << SizeFields(comparison, FindRound(strategy, row.level, row.round)) << ','
          << row.iteration << ',' << row.evaluations << ',' << Formatted("%.6f", row.seconds) << ','
          << row.energy << ',';
      if (std::isfinite(row.rmse)) csv << row.rmse;
      csv << ',';
      if (std::isfinite(row.camera_px)) csv << row.camera_px;
      csv << ',' << (row.accepted ? 1 : 0) << ",\n";
    }
    for (const ComparedRound& round : strategy.rounds) {
      if (round.reason.empty()) continue;
      csv << mode << ',' << strategy.name << ',' << round.level << ',' << round.round << ','
          << SizeFields(comparison, &round) << ",,,,,,,," << Quoted(round.reason) << '\n';
    }
    if (!strategy.reason.empty()) {
      csv << mode << ',' << strategy.name << ",,," << SizeFields(comparison, nullptr) << ",,,,,,,,"
          << Quoted(strategy.reason) << '\n';
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
    if (comparison.options.mode == CompareMode::kWhole) continue;
    const double possible =
        totals.energy_initial - BestEnergy(comparison, round.level, round.round);
    if (!(possible > 0)) continue;
    share_sum += (totals.energy_initial - totals.energy_final) / possible;
    ++shares;
  }
  if (shares > 0) totals.reduction_share = share_sum / shares;
  if (totals.reason.empty()) {
    totals.status = ComparedStatus::kOk;
  } else if (solved > 0) {
    totals.status = ComparedStatus::kPartly;
  } else {
    totals.status =
        totals.reason.rfind("refused", 0) == 0 ? ComparedStatus::kRefused : ComparedStatus::kFailed;
  }
  return totals;
}

nlohmann::ordered_json ComparisonJson(const Comparison& comparison) {
  nlohmann::ordered_json json;
  json["mode"] = NameOf(comparison.options.mode);
  json["reference_by_round"] = comparison.references;
  json["pairs"] = {{"method", NameOf(comparison.selection.recipe.method)},
                   {"count", comparison.selection.pairs.size()}};
  if (comparison.has_truth) json["before"] = ToJson(comparison.before);
  json["strategies"] = nlohmann::ordered_json::array();
  for (const ComparedStrategy& strategy : comparison.strategies) {
    const StrategyTotals totals = TotalsOf(comparison, strategy);
    nlohmann::ordered_json entry;
    entry["strategy"] = strategy.name;
    entry["status"] = NameOf(totals.status);
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

namespace {

// Of the rounds that had cameras among their unknowns: a table each, in the order of the run; empty where there was none.
std::string CameraTables(const Comparison& comparison, size_t width) {
  std::string tables;
  std::set<std::pair<int, int>> done;  // level, round
  for (const ComparedStrategy& any : comparison.strategies) {
    for (const ComparedRound& of : any.rounds) {
      if (of.cameras == 0 || !done.insert({of.level, of.round}).second) continue;
      tables += "\n" + std::to_string(of.width) + "x" + std::to_string(of.height) + ", round " +
                std::to_string(of.round + 1) + ", with " + std::to_string(of.cameras) +
                " cameras as unknowns\nstrategy" + std::string(width - 8, ' ') +
                "                      energy        RMSE    seconds  iterations  evaluations" +
                "  cameras moved\n";
      for (const ComparedStrategy& strategy : comparison.strategies) {
        const ComparedRound* round = FindRound(strategy, of.level, of.round);
        if (round == nullptr) continue;
        tables += strategy.name + std::string(width - strategy.name.size(), ' ');
        if (!round->reason.empty()) {
          tables += "  " + round->reason + "\n";
          continue;
        }
        tables += Padded(Formatted("%.6g", EnergyOf(round->trial.energy_initial)) + " -> " +
                             Formatted("%.6g", EnergyOf(round->trial.energy_final)),
                         28) +
                  Padded(Formatted("%.4g", round->rmse), 12) +
                  Padded(Formatted("%.2f", round->trial.seconds), 11) +
                  Padded(std::to_string(round->trial.solve.iterations), 12) +
                  Padded(std::to_string(round->trial.evaluations), 13) +
                  Padded(Formatted("%.3f px", round->trial.camera_px), 15) + "\n";
      }
    }
  }
  return tables;
}

}  // namespace

std::string ComparisonTable(const Comparison& comparison) {
  const bool frozen = comparison.options.mode == CompareMode::kFrozen;
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
    if (totals.status == ComparedStatus::kOk || totals.status == ComparedStatus::kPartly) {
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
  return table + CameraTables(comparison, width);
}

}  // namespace burin
