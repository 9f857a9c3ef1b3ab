#include <algorithm>
#include <iostream>
#include <string>

#include "apps/commands/command.h"
#include "apps/commands/commands.h"
#include "core/solve/solver_strategy.h"

namespace burin {

void AddSolversCommand(Program* program) {
  Command command = program->Add("solvers", "list what --solver.type can be");
  command.OnRun([] {
    size_t width = 0;
    for (const Strategy& strategy : Strategies()) width = std::max(width, strategy.name.size());
    for (const Strategy& strategy : Strategies()) {
      std::cout << strategy.name << std::string(width + 2 - strategy.name.size(), ' ')
                << strategy.description << "\n";
    }
    const SolverOptions defaults;
    std::cout << "auto" << std::string(width - 2, ' ') << "lm_cholesky up to "
              << defaults.cholesky_max_unknowns
              << " unknowns (solver.cholesky_max_unknowns), else lm_pcg\n";
  });
}

}  // namespace burin
