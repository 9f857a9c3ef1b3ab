#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/commands/command.h"
#include "apps/commands/commands.h"
#include "apps/commands/pair_pictures.h"
#include "apps/run/output_folder.h"
#include "apps/run/pipeline.h"
#include "apps/run/run_output.h"
#include "apps/run/scene_arguments.h"
#include "core/image/picture.h"
#include "core/mesh/mesh_io.h"
#include "core/scene/doubts.h"
#include "core/support/atomic_file.h"
#include "core/support/config.h"
#include "core/support/error.h"
#include "core/support/json_file.h"
#include "core/support/parallel.h"
#include "core/support/stopwatch.h"
#include "selection/pair_file.h"
#include "selection/pair_selection.h"

namespace burin {
namespace {

struct SelectCommand {
  SelectOptions options;
  OptionSet set;
  SceneArguments source;
  std::string mesh_path;
  std::string output_path;
  bool no_pictures = false;
  void Run();
};

Coverage CoverageOf(const PairSurvey& survey, const PairsRecipe& recipe,
                    const std::vector<CameraPair>& pairs) {
  Coverage coverage(survey.facets, survey.view_count, !recipe.swaps.printed_facets);
  for (const CameraPair& pair : pairs) coverage.Add(pair);
  return coverage;
}

void SelectCommand::Run() {
  options.pairs.Check();
  const ThreadScope threads(options.threads);
  const OutputFolder output(output_path);
  const std::filesystem::path& folder = output.path();
  const Scene scene = LoadScene(source.Source(), /*with_images=*/false);
  for (const std::string& doubt : DoubtsAbout(scene)) std::cerr << doubt << "\n";
  TriangleMesh mesh = ReadMesh(mesh_path);
  const MeshParts parts = OrientAndCheck(scene, options.mesh, mesh_path, &mesh);
  for (const std::string& line : parts.lines) std::cerr << line << "\n";
  const Stopwatch watch;
  PairSurvey survey;
  const PairSelection selection = SelectPairs(scene, mesh, options.pairs, &survey);
  const PairsRecipe& recipe = selection.recipe;
  const double seconds = watch.Seconds();
  for (const std::string& warning : selection.warnings) {
    std::cerr << "no partner: " << warning << "\n";
  }

  WriteTextAtomically(folder / "pair_terms.csv", PairTermsCsv(scene, survey, selection));
  WriteTextAtomically(folder / "config.toml", ConfigText(set));
  const Coverage before = CoverageOf(survey, recipe, selection.initial_pairs);
  const Coverage after = CoverageOf(survey, recipe, selection.pairs);
  if (!no_pictures) {
    WritePicture(folder / "graph.png", PairGraphPicture(scene, mesh, selection.pairs));
    WritePicture(folder / "coverage.png",
                 CoveragePicture(scene, mesh, before.Counts(), after.Counts()));
    WritePicture(folder / "energy_matrix.png",
                 EnergyMatrixPicture(scene, PairEnergyTable(survey, recipe), selection.pairs));
  }
  WriteTextAtomically(folder / "pairs.json", JsonText(PairsJson(scene, survey, selection)));
  const auto swaps = std::count_if(selection.swaps.begin(), selection.swaps.end(),
                                   [](const SwapTrial& trial) { return trial.accepted; });
  std::cout << "wrote " << (folder / "pairs.json").string() << ": " << NameOf(recipe.method) << ", "
            << selection.pairs.size() << " pairs of " << scene.views.size() << " views\n"
            << std::fixed << std::setprecision(3) << "coverage of the facets that two views see: "
            << "mean " << before.Mean() << " -> " << after.Mean() << ", standard deviation "
            << before.StdDev() << " -> " << after.StdDev() << ", covered "
            << 100 * before.CoveredShare() << " % -> " << 100 * after.CoveredShare() << " %; "
            << swaps << " swaps of " << selection.swaps.size() << " tried\n"
            << std::setprecision(1) << seconds << " s, " << std::lround(PeakMemoryMib())
            << " MiB\n";
}

}  // namespace

void AddSelectCommand(Program* program) {
  Command command = program->Add("select", "choose camera pairs from the mesh and show why");
  const auto state = std::make_shared<SelectCommand>();
  state->options.Describe(&state->set);
  command.Scene(&state->source, /*photographs=*/false)[0].Required();
  command
      .Text("--mesh", "FILE (required)", &state->mesh_path,
            "mesh to start from: PLY, OBJ, OFF or STL")
      .Required();
  command
      .Text("--output", "DIR (required)", &state->output_path,
            "folder for pairs.json, pair_terms.csv and pictures")
      .Required();
  command.Flag("--no-pictures", &state->no_pictures, "leave the pictures out");
  command.Options(&state->set);
  command.OnRun([state] { state->Run(); });
}

}  // namespace burin
