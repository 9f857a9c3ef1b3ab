#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/commands/command.h"
#include "apps/commands/commands.h"
#include "apps/run/comparison_output.h"
#include "apps/run/judged_scene.h"
#include "apps/run/memory_limit.h"
#include "apps/run/output_folder.h"
#include "apps/run/pipeline.h"
#include "apps/run/progress.h"
#include "apps/run/run_output.h"
#include "apps/run/scene_arguments.h"
#include "apps/run/solver_comparison.h"
#include "apps/run/verdict_output.h"
#include "core/mesh/mesh_io.h"
#include "core/support/atomic_file.h"
#include "core/support/config.h"
#include "core/support/error.h"
#include "core/support/json_file.h"
#include "core/support/parallel.h"
#include "core/support/stopwatch.h"

namespace burin {
namespace {

struct CompareCommand {
  PipelineOptions pipeline;
  CompareOptions compare;
  OptionSet set;
  SceneArguments source;
  std::string mesh_path;
  std::string truth_path;
  std::string output_path;
  void Run();
};

// Why nothing ran, in one line.
std::string Reasons(const Comparison& comparison) {
  std::string text = "no strategy ran";
  for (const ComparedStrategy& strategy : comparison.strategies) {
    text += "; " + strategy.name + ": " + TotalsOf(comparison, strategy).reason;
  }
  return text;
}

// The strategy that needs most decides.
MemoryCheck CheckMemoryOfAll(const Scene& scene, const TriangleMesh& mesh, PipelineOptions pipeline,
                             std::vector<std::string> names) {
  names.push_back(pipeline.refinement.solver.type);  // of the reference run
  MemoryCheck largest;
  for (const std::string& name : names) {
    pipeline.refinement.solver.type = name;
    const MemoryCheck check = CheckMemory(scene, mesh, pipeline);
    if (check.estimate.Mib() > largest.estimate.Mib()) largest = check;
  }
  return largest;
}

void CompareCommand::Run() {
  const Stopwatch watch;
  pipeline.Check();
  compare.Names();
  compare.evaluation.Thresholds();
  const ThreadScope threads(pipeline.threads);
  const OutputFolder output(output_path);
  const std::filesystem::path& folder = output.path();
  MeshReport report;
  TriangleMesh mesh = ReadMesh(mesh_path, &report);
  const MemoryCheck memory = CheckMemoryOfAll(LoadScene(source.Source(), /*with_images=*/false),
                                              mesh, pipeline, compare.Names());
  const Scene scene = LoadScene(source.Source(pipeline.masks.meaning));
  const MeshParts parts = OrientAndCheck(scene, pipeline.mesh, mesh_path, &mesh);
  Truth truth;
  if (!truth_path.empty()) truth = ReadTruth(truth_path);

  Progress progress;
  progress.Begin(1);
  progress.Line("read " + std::to_string(scene.views.size()) + " views; mesh: " + report.Brief());
  for (const std::string& line : parts.lines) progress.Line(line);
  // A comparison keeps its rows whatever the verdict is.
  PipelineOptions kept = pipeline;
  if (kept.verdict.action == VerdictAction::kStop) kept.verdict.action = VerdictAction::kWarn;
  const JudgedScene judged = JudgeAndSelect(scene, mesh, kept);
  for (const std::string& line : judged.lines) progress.Line(line);
  const Comparison comparison = CompareSolvers(
      judged.Used(scene), mesh, pipeline, compare, truth_path.empty() ? nullptr : &truth,
      [&](const std::string& line) { progress.Line(line); }, &judged.selection);
  progress.End();
  if (!comparison.AnythingRan()) throw InputError(Reasons(comparison));

  nlohmann::ordered_json summary;
  summary["command"] = "burin compare-solvers " + source.Text() + " --mesh " + mesh_path +
                       (truth_path.empty() ? "" : " --truth " + truth_path) + " --output " +
                       output_path + " --config " + (folder / "config.toml").string();
  summary["versions"] = VersionsJson();
  summary["options"] = OptionsJson(set);
  summary["input"] = {{"scene", source.scene},
                      {"mesh", mesh_path},
                      {"truth", truth_path},
                      {"views", scene.views.size()},
                      {"vertices", mesh.vertices.size()},
                      {"faces", mesh.faces.size()}};
  summary["verdict"] = judged.judged ? VerdictJson(judged.verdict, scene, judged.left_out)
                                     : nlohmann::ordered_json();
  summary.update(ComparisonJson(comparison));
  summary["threads"] = ThreadCount();
  summary["peak_memory_mib"] = std::round(PeakMemoryMib());
  summary["memory"] = MemoryJson(memory);
  summary["seconds"] = watch.Seconds();

  WriteTextAtomically(folder / "compare.csv", ComparisonCsv(comparison));
  WriteTextAtomically(folder / "config.toml", ConfigText(set));
  WriteTextAtomically(folder / "compare.json", JsonText(summary));
  std::cout << ComparisonTable(comparison) << "wrote " << (folder / "compare.csv").string() << ", "
            << (folder / "compare.json").string()
            << "\nto draw them, in burin's source folder: ./run charts "
            << std::filesystem::absolute(folder).string() << "\n";
}

}  // namespace

void AddCompareCommand(Program* program) {
  Command command = program->Add("compare-solvers",
                                 "run every strategy from the same start, as table, CSV and JSON");
  const auto state = std::make_shared<CompareCommand>();
  // The same facets for every strategy.
  state->pipeline.refinement.surface.remesh = SurfaceFacets::kNone;
  state->pipeline.Describe(&state->set);
  state->compare.Describe(&state->set);
  command.Scene(&state->source, /*photographs=*/true)[0].Required();
  command
      .Text("--mesh", "FILE (required)", &state->mesh_path,
            "mesh to start from: PLY, OBJ, OFF or STL")
      .Required();
  command.Text("--truth", "FILE", &state->truth_path,
               "mesh, or PLY point cloud: also measure the error, as burin evaluate does");
  command
      .Text("--output", "DIR (required)", &state->output_path,
            "folder for compare.csv and compare.json")
      .Required();
  command.Options(&state->set, {{"compare.solvers", "--solvers"}});
  command.OnRun([state] { state->Run(); });
}

}  // namespace burin
