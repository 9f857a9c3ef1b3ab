#include "apps/run/memory_limit.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

namespace burin {
namespace {

constexpr double kMib = 1024.0 * 1024.0;

namespace fs = std::filesystem;

// The number of a one-number file; infinity for "max" and where there is no such file.
double BytesOfFile(const fs::path& path) {
  std::ifstream file(path);
  double value = 0;
  return file >> value ? value : std::numeric_limits<double>::infinity();
}

// The number after `key` in a file of "key number" lines; `otherwise` when there is none.
double ValueOf(const fs::path& path, const std::string& key, double otherwise) {
  std::ifstream file(path);
  std::string name;
  std::string rest;
  while (file >> name && std::getline(file, rest)) {
    if (name == key) return std::strtod(rest.c_str(), nullptr);
  }
  return otherwise;
}

// The names of a hierarchy of control groups.
struct GroupFiles {
  const char* root;
  const char* limit;
  const char* used;
  const char* cache;  // key of memory.stat
};
constexpr GroupFiles kVersion1 = {"/sys/fs/cgroup/memory", "memory.limit_in_bytes",
                                  "memory.usage_in_bytes", "total_cache"};
constexpr GroupFiles kVersion2 = {"/sys/fs/cgroup", "memory.max", "memory.current", "file"};

// What the limit of one group leaves, MiB; infinity without one. Pages of files count as used there but
// are given up when memory is short.
double LeftOfOneGroupMib(const fs::path& group, const GroupFiles& files) {
  const double limit = BytesOfFile(group / files.limit);
  const double used = BytesOfFile(group / files.used);
  if (!std::isfinite(limit) || !std::isfinite(used)) {
    return std::numeric_limits<double>::infinity();
  }
  const double cache = ValueOf(group / "memory.stat", files.cache, 0);
  return std::max(0.0, limit - (used - cache)) / kMib;
}

// The least that the process's group and those above it leave. In a container the path of the group may
// be one outside it: then only the root is there.
double LeftOfGroupMib() {
  double left = std::numeric_limits<double>::infinity();
  std::ifstream lines("/proc/self/cgroup");
  std::string line;
  while (std::getline(lines, line)) {  // NUMBER:CONTROLLERS:PATH
    const size_t first = line.find(':');
    const size_t second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    const bool is_version_2 = controllers == ",,";
    if (!is_version_2 && controllers.find(",memory,") == std::string::npos) continue;
    const GroupFiles& files = is_version_2 ? kVersion2 : kVersion1;
    fs::path group = fs::path(line.substr(second + 1)).relative_path();
    while (true) {
      left = std::min(left, LeftOfOneGroupMib(files.root / group, files));
      if (group.empty()) break;
      group = group.parent_path();
    }
  }
  return left;
}

std::string Gigabytes(double mib) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.2f GB", mib / 1024);
  return text;
}

}  // namespace

double AvailableMemoryMib() {
  const double machine_mib =
      ValueOf("/proc/meminfo", "MemAvailable:", std::numeric_limits<double>::infinity()) / 1024;
  double size_pages = 0;
  double own_pages = 0;
  std::ifstream statm("/proc/self/statm");
  if (!(statm >> size_pages >> own_pages)) own_pages = 0;
  const double own_mib = own_pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / kMib;
  return own_mib + std::min(machine_mib, LeftOfGroupMib());
}

MemoryCheck CheckMemory(const Scene& scene, const TriangleMesh& mesh,
                        const PipelineOptions& options, double held_bytes) {
  const SurfaceInViews surface = LookAtSurface(scene, mesh);
  MemoryCheck check;
  check.estimate = EstimateMemory(scene, mesh, surface, options, held_bytes);
  const bool given = options.memory.limit_gb > 0;
  check.limit_mib = given ? 1024 * options.memory.limit_gb : AvailableMemoryMib();
  if (check.estimate.Mib() <= check.limit_mib) return check;

  std::string fitting;
  const auto offer = [&](const PipelineOptions& changed, const std::string& flags) {
    const double mib = EstimateMemory(scene, mesh, surface, changed, held_bytes).Mib();
    if (mib > check.limit_mib) return false;
    fitting += (fitting.empty() ? "" : ", or ") + flags + " (" + Gigabytes(mib) + ")";
    return true;
  };
  const LevelOptions& level = options.refinement.level;
  for (int finer = 1; finer < level.count; ++finer) {
    PipelineOptions changed = options;
    changed.refinement.level.finest = level.finest + finer;
    changed.refinement.level.count = level.count - finer;
    if (offer(changed, "--level.finest " + std::to_string(level.finest + finer) +
                           " --level.count " + std::to_string(level.count - finer))) {
      break;
    }
  }
  for (int times = 2; times <= 64; times *= 2) {
    PipelineOptions changed = options;
    changed.refinement.level.max_facet_px = times * level.max_facet_px;
    char value[32];
    std::snprintf(value, sizeof(value), "%g", times * level.max_facet_px);
    if (offer(changed, std::string("--level.max_facet_px ") + value)) break;
  }
  for (const char* solver : {"lm_cgnr", "lbfgs"}) {
    PipelineOptions changed = options;
    changed.refinement.solver.type = solver;
    if (offer(changed, std::string("--solver.type ") + solver)) break;
  }
  throw MemoryLimitError(
      "the run would need about " + Gigabytes(check.estimate.Mib()) + " (level " +
      std::to_string(check.estimate.level) + ", " + std::to_string(check.estimate.faces) +
      " faces), more than the " + Gigabytes(check.limit_mib) +
      (given ? " of memory.limit_gb" : " available (memory.limit_gb sets another limit)") + "; " +
      (fitting.empty() ? "neither a coarser level.finest nor 64 x level.max_facet_px fits"
                       : "this would fit: " + fitting));
}

nlohmann::ordered_json MemoryJson(const MemoryCheck& check) {
  nlohmann::ordered_json json;
  json["estimate_mib"] = std::round(check.estimate.Mib());
  json["limit_mib"] = std::round(check.limit_mib);
  json["level"] = check.estimate.level;
  json["faces"] = check.estimate.faces;
  json["vertices"] = check.estimate.vertices;
  for (const auto& [name, mib] : check.estimate.parts) json["parts_mib"][name] = std::round(mib);
  return json;
}

}  // namespace burin
