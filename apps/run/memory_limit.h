// Refuses a run that would not fit in memory before it begins (option memory.limit_gb).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <stdexcept>
#include <string>

#include "apps/run/memory_estimate.h"

namespace burin {

// The work would need more memory than it may have; the command line turns it into one line and exit
// code 3. Thrown before the work.
class MemoryLimitError : public std::runtime_error {
 public:
  explicit MemoryLimitError(const std::string& message) : std::runtime_error(message) {}
};

// What this process may come to: its own memory and what the machine has available, or, in a
// container, what is left of its limit.
double AvailableMemoryMib();

struct MemoryCheck {
  MemoryEstimate estimate;
  double limit_mib = 0;
};

// Throws MemoryLimitError when the estimate is above options.memory.limit_gb, or where that is 0,
// above AvailableMemoryMib(); its line says what would fit.
MemoryCheck CheckMemory(const Scene& scene, const TriangleMesh& mesh,
                        const PipelineOptions& options, double held_bytes = 0);

// For summary.json, beside the measured peak.
nlohmann::ordered_json MemoryJson(const MemoryCheck& check);

}  // namespace burin
