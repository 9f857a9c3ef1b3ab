#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "apps/commands/command.h"
#include "apps/commands/commands.h"
#include "apps/run/free_space_output.h"
#include "apps/run/judged_scene.h"
#include "apps/run/mesh_parts.h"
#include "apps/run/output_folder.h"
#include "apps/run/pipeline.h"
#include "apps/run/scene_arguments.h"
#include "apps/run/verdict_output.h"
#include "core/evidence/free_space.h"
#include "core/evidence/offset_picture.h"
#include "core/evidence/verdict.h"
#include "core/image/picture.h"
#include "core/mesh/mesh_io.h"
#include "core/scene/doubts.h"
#include "core/support/atomic_file.h"
#include "core/support/json_file.h"
#include "core/support/parallel.h"
#include "selection/pair_selection.h"

namespace burin {
namespace {

struct CheckCommand {
  SelectOptions options;
  OptionSet set;
  SceneArguments source;
  std::string mesh_path;
  std::string output_path;
  bool json = false;
  void Run() const;
};

void CheckCommand::Run() const {
  options.pairs.Check();
  const ThreadScope threads(options.threads);
  std::optional<OutputFolder> output;
  if (!output_path.empty()) output.emplace(output_path);
  TriangleMesh mesh = ReadMesh(mesh_path);
  const Scene scene = LoadScene(source.Source());
  for (const std::string& doubt : DoubtsAbout(scene)) std::cerr << doubt << "\n";
  const MeshParts parts = OrientAndCheck(scene, options.mesh, mesh_path, &mesh);
  PairSelection selection;
  double seconds = 0;
  const SceneVerdict verdict = SelectAndJudge(scene, mesh, options.pairs, &selection, &seconds);
  nlohmann::ordered_json found = CheckJson(verdict, scene, parts);
  const FreeSpace free_space = FindFreeSpace(scene, mesh, selection.pairs);
  found["free_space"] = FreeSpaceJson(free_space);
  const std::string document = JsonText(found);
  if (output.has_value()) {
    WritePicture(output->path() / "offsets.png", OffsetPicture(verdict, scene));
    WriteTextAtomically(output->path() / "verdict.json", document);
  }
  for (const std::string& line : parts.lines) std::cerr << line << "\n";
  std::cout << (json ? document : VerdictText(verdict, scene));
  if (!json && !free_space.patches.empty() && verdict.verdict != Verdict::kWrong) {
    std::cout << FreeSpaceText(free_space, "a refinement leaves them out") << '\n';
  }
  if (verdict.verdict == Verdict::kWrong) {
    std::cout.flush();
    throw CannotBeRight("this cannot be right: " + verdict.reason);
  }
}

}  // namespace

void AddCheckCommand(Program* program) {
  Command command =
      program->Add("check", "say whether cameras, photographs and mesh fit each other");
  const auto state = std::make_shared<CheckCommand>();
  state->options.Describe(&state->set);
  command.Scene(&state->source, /*photographs=*/true)[0].Required();
  command
      .Text("--mesh", "FILE (required)", &state->mesh_path,
            "mesh to start from: PLY, OBJ, OFF or STL")
      .Required();
  command.Text("--output", "DIR", &state->output_path,
               "folder for offsets.png, a picture of the offsets by view, and verdict.json");
  command.Flag("--json", &state->json, "print JSON");
  command.Options(&state->set);
  command.OnRun([state] { state->Run(); });
}

}  // namespace burin
