#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "apps/commands/command.h"
#include "apps/commands/commands.h"
#include "apps/commands/refine_texts.h"
#include "apps/commands/start_file.h"
#include "apps/run/cameras_folder.h"
#include "apps/run/cameras_output.h"
#include "apps/run/checkpoint.h"
#include "apps/run/debug_images.h"
#include "apps/run/free_space_output.h"
#include "apps/run/judged_scene.h"
#include "apps/run/output_folder.h"
#include "apps/run/pipeline.h"
#include "apps/run/progress.h"
#include "apps/run/run_output.h"
#include "apps/run/scene_arguments.h"
#include "apps/run/stop_signals.h"
#include "apps/run/verdict_output.h"
#include "core/image/picture.h"
#include "core/mesh/mesh_io.h"
#include "core/support/atomic_file.h"
#include "core/support/config.h"
#include "core/support/error.h"
#include "core/support/json_file.h"
#include "core/support/parallel.h"
#include "core/support/stopwatch.h"
#include "core/visibility/render.h"
#include "costs/pair_kernel.h"

namespace burin {
namespace {

constexpr const char* kFreeOnResume[] = {"--run.threads", "--memory.limit_gb"};  // same result

struct RefineCommand {
  PipelineOptions options;
  OptionSet set;
  SceneArguments source;
  std::string mesh_path;
  std::string output_path;
  std::string resume_path;
  bool pictures = false;
  bool debug_images = false;
  bool level_meshes = false;
  void Run();
  std::vector<std::string> given;  // options of `set`, and --config, on the command line
  // Everything the command line would have given, from the checkpoint of --resume.
  void TakeFrom(const Checkpoint& checkpoint);
  void RefuseToReplaceInputs(const std::filesystem::path& folder) const;
  Checkpoint FirstCheckpoint(const Scene& scene, const TriangleMesh& mesh) const;
  JudgedScene JudgeOrGoOn(const Scene& scene, const TriangleMesh& mesh,
                          Checkpoint* checkpoint) const;
  [[noreturn]] void HandBack(const JudgedScene& judged, const RunInputs& inputs,
                             const std::filesystem::path& folder, double seconds) const;
  void WritePictures(const std::filesystem::path& folder, const Scene& scene,
                     const TriangleMesh& before, const TriangleMesh& after) const;
};

// A run that has been finished in this folder and not begun anew.
bool IsComplete(const std::filesystem::path& folder) {
  std::error_code error;
  return !std::filesystem::exists(std::filesystem::symlink_status(CheckpointPath(folder), error)) &&
         std::filesystem::exists(folder / "summary.json", error);
}

std::filesystem::path LevelPath(const std::filesystem::path& folder, int level) {
  return folder / ("level_" + std::to_string(level) + ".ply");
}

void CheckUnchanged(const Checkpoint& checkpoint, const Scene& scene, const TriangleMesh& mesh) {
  if (checkpoint.inputs != InputsFingerprint(scene, mesh)) {
    throw InputError("--resume: " + checkpoint.source.scene + " or " + checkpoint.mesh_path +
                     " is not what it was when the run began");
  }
}

// The middle view of the scene: its photograph and both meshes, shaded from its camera.
void RefineCommand::WritePictures(const std::filesystem::path& folder, const Scene& scene,
                                  const TriangleMesh& before, const TriangleMesh& after) const {
  const View& view = scene.views[scene.views.size() / 2];
  cv::Mat photograph;
  view.gray.convertTo(photograph, CV_8U);
  WritePicture(
      folder / "before_after.png",
      SideBySide({photograph, RenderShaded(before, view.camera), RenderShaded(after, view.camera)},
                 {view.name, "before", "after"}));
}

void RefineCommand::TakeFrom(const Checkpoint& checkpoint) {
  std::vector<std::pair<Option*, std::string>> kept;
  for (const std::string& flag : given) {
    Option* option = set.Find(flag.substr(2));
    if (std::find(std::begin(kFreeOnResume), std::end(kFreeOnResume), flag) ==
        std::end(kFreeOnResume)) {
      throw InputError("--resume: goes on with the options of the run in " + resume_path +
                       "; only --run.threads and --memory.limit_gb may be given");
    }
    kept.emplace_back(option, option->Text());
  }
  ParseConfig(checkpoint.config, CheckpointPath(resume_path).string(), &set);
  for (const auto& [option, text] : kept) {
    std::string ignored;  // it was accepted once
    option->Set(text, &ignored);
  }
  output_path = resume_path;
  PlaceInputs(checkpoint, resume_path, &source, &mesh_path);
  options.pairs.file = MovedPath(options.pairs.file, checkpoint.folder, resume_path);
  pictures = checkpoint.pictures;
  debug_images = checkpoint.debug_images;
  level_meshes = checkpoint.level_meshes;
}

Checkpoint RefineCommand::FirstCheckpoint(const Scene& scene, const TriangleMesh& mesh) const {
  Checkpoint checkpoint;
  checkpoint.source = source.Absolute();
  checkpoint.mesh_path = std::filesystem::absolute(mesh_path).string();
  checkpoint.folder = std::filesystem::absolute(output_path).lexically_normal().string();
  checkpoint.config = ConfigText(set);
  checkpoint.inputs = InputsFingerprint(scene, mesh);
  checkpoint.instruction_set = KernelInstructionSet();
  checkpoint.pictures = pictures;
  checkpoint.debug_images = debug_images;
  checkpoint.level_meshes = level_meshes;
  return checkpoint;
}

// A run that goes on has been judged; its views and pairs must be those that it began with.
JudgedScene RefineCommand::JudgeOrGoOn(const Scene& scene, const TriangleMesh& mesh,
                                       Checkpoint* checkpoint) const {
  JudgedScene judged;
  if (resume_path.empty()) {
    judged = JudgeAndSelect(scene, mesh, options);
    *checkpoint = FirstCheckpoint(scene, mesh);
    checkpoint->left_out = judged.left_out;
    if (judged.judged) {
      checkpoint->verdict = JsonText(VerdictJson(judged.verdict, scene, judged.left_out));
    }
    checkpoint->pairs = judged.selection.pairs;
    return judged;
  }
  judged = SelectWithout(scene, mesh, options, checkpoint->left_out);
  if (checkpoint->pairs != judged.selection.pairs) {
    throw InputError("--resume: the camera pairs are not those that the run began with");
  }
  return judged;
}

// What cannot be right is not refined: the mesh given is the result.
void RefineCommand::HandBack(const JudgedScene& judged, const RunInputs& inputs,
                             const std::filesystem::path& folder, double seconds) const {
  PipelineResult result;
  result.mesh = *inputs.mesh;
  result.selection = judged.selection;
  result.by_tracks = judged.by_tracks;
  nlohmann::ordered_json summary = SummaryJson(inputs, options, result, seconds);
  summary["complete"] = true;
  WriteSurface(folder, result);
  RemoveCameras(folder);
  WriteTextAtomically(folder / "trace.csv", TraceCsv({}));
  WriteTextAtomically(folder / "config.toml", ConfigText(set));
  WriteTextAtomically(folder / "summary.json", JsonText(summary));
  std::filesystem::remove(CheckpointPath(folder));
  throw CannotBeRight("this cannot be right: " + judged.verdict.reason + "; " +
                      (folder / "refined.ply").string() +
                      " is the input mesh (verdict.action = warn refines it all the same)");
}

void RefineCommand::RefuseToReplaceInputs(const std::filesystem::path& folder) const {
  std::vector<std::filesystem::path> written = {folder / "refined.ply", folder / "whole.ply"};
  for (int level = 0; level_meshes && level < 32; ++level) {
    written.push_back(LevelPath(folder, level));
  }
  RefuseToReplace("--mesh", mesh_path, written);
  RefuseToReplace("the scene", source.scene, CamerasFolders(folder));
}

void RefineCommand::Run() {
  const Stopwatch watch;
  const StopSignals signals;
  Checkpoint checkpoint;
  if (!resume_path.empty()) {
    if (IsComplete(resume_path)) {
      std::cout << resume_path << ": the run is complete, there is nothing to resume\n";
      return;
    }
    checkpoint = ReadCheckpoint(CheckpointPath(resume_path));
    TakeFrom(checkpoint);
  }
  options.Check();
  if (!options.pairs.file.empty()) {
    options.pairs.file = std::filesystem::absolute(options.pairs.file).string();
  }
  const ThreadScope threads(options.threads);
  const OutputFolder output(output_path);
  const std::filesystem::path& folder = output.path();
  RefuseToReplaceInputs(folder);
  if (options.refinement.cameras.refine != CameraUnknowns::kNone) CheckCamerasFolders(folder);
  if (mesh_path.empty()) mesh_path = MakeInitMesh(source, options.masks.meaning, folder, signals);
  MeshReport report;
  TriangleMesh mesh = ReadMesh(mesh_path, &report);
  RunInputs inputs;
  inputs.memory = CheckMemory(LoadScene(source.Source(), /*with_images=*/false), mesh, options);
  const Scene whole = LoadScene(source.Source(options.masks.meaning));
  inputs.parts = OrientAndCheck(whole, options.mesh, mesh_path, &mesh);
  if (!resume_path.empty()) CheckUnchanged(checkpoint, whole, mesh);
  const std::string instruction_set = KernelInstructionSet();
  const std::string before = std::exchange(checkpoint.instruction_set, instruction_set);
  signals.ThrowIfCaught();
  inputs.command_line = "burin refine " + source.Text() + " --mesh " + mesh_path + " --output " +
                        output_path + " --config " + (folder / "config.toml").string();
  inputs.scene_path = source.scene;
  inputs.mesh_path = mesh_path;
  inputs.scene = &whole;
  inputs.mesh = &mesh;
  inputs.mesh_report = report.Brief();
  inputs.load_seconds = watch.Seconds();

  Progress progress;
  progress.Begin(1);
  progress.Line("read " + std::to_string(whole.views.size()) + " views, " +
                std::to_string(whole.points.size()) + " points; mesh: " + report.Brief());
  for (const std::string& line : inputs.parts.lines) progress.Line(line);
  if (checkpoint.state.has_value() && before != instruction_set) {
    progress.Line("the run so far used " + before + ", this machine has " + instruction_set +
                  ": the result may differ in its last digits from that of one machine");
  }
  const std::filesystem::path checkpoint_path = CheckpointPath(folder);
  const Stopwatch selection_watch;
  const JudgedScene judged = JudgeOrGoOn(whole, mesh, &checkpoint);
  const Scene& scene = judged.Used(whole);
  const PairSelection& selection = judged.selection;
  const double selection_seconds = selection_watch.Seconds() - judged.seconds -
                                   (judged.by_tracks.has_value() ? judged.by_tracks->seconds : 0);
  std::vector<std::string> names;
  for (const View& view : scene.views) names.push_back(view.name);
  inputs.verdict = checkpoint.verdict;
  inputs.verdict_seconds = judged.seconds;
  for (const std::string& line : judged.lines) progress.Line(line);
  signals.ThrowIfCaught();
  RemoveTemporaries(folder);
  if (judged.stop) {
    if (judged.by_tracks.has_value()) {
      for (const std::string& line : TrackStepText(*judged.by_tracks, scene)) progress.Line(line);
    }
    progress.End();
    HandBack(judged, inputs, folder, watch.Seconds());
  }
  if (resume_path.empty()) WriteCheckpoint(checkpoint_path, checkpoint);
  const std::optional<RefinementState> start = checkpoint.state;
  PipelineParts parts;
  parts.selection = &selection;
  parts.by_tracks = judged.by_tracks.has_value() ? &*judged.by_tracks : nullptr;
  parts.start = start.has_value() ? &*start : nullptr;
  parts.tracks_hold_all = HoldsAllViews(checkpoint.cameras);
  parts.on_small_levels = [&](const SmallLevels& small) { progress.Line(SmallLevelsText(small)); };
  parts.on_cameras = [&](const TrackStep& step) {
    for (const std::string& line : TrackStepText(step, scene)) progress.Line(line);
    checkpoint.cameras = JsonText(TrackStepJson(step, scene));
  };
  parts.on_free_space = [&](const FreeSpace& free_space) {
    progress.Line(FreeSpaceText(free_space, options.surface.free_space == FreeSpaceAction::kCut
                                                ? "they are cut away"
                                                : "they take no part (surface.free_space)"));
  };
  parts.observers.on_iteration = [&](const RefinementEvent& event) {
    checkpoint.events.push_back(event);
    progress.Update(event.done, EventText(event));
    return signals.Caught() == 0;
  };
  parts.observers.on_level = [&](const LevelSummary& level, const TriangleMesh& now) {
    const bool crossings = options.refinement.guard.crossings != Crossings::kOff;
    for (const std::string& line : LevelTexts(level, crossings)) progress.Line(line);
    if (!level_meshes || level.interrupted) return;
    WriteMesh(LevelPath(folder, level.level), now);
  };
  parts.observers.on_state = [&](const RefinementState& state) {
    checkpoint.state = state;
    WriteCheckpoint(checkpoint_path, checkpoint);
  };
  parts.observers.on_round = [&](const RoundContext& context, const TriangleMesh& now,
                                 const RoundSummary& round) {
    if (round.round == 0) {
      if (const std::string views = ViewsText(context, names); !views.empty()) progress.Line(views);
    }
    progress.Line(RoundText(context, now, round));
    if (debug_images && round.round == 0) {
      MakeFolder(folder / "debug");
      WriteDebugImages(folder / "debug", context.level, context, options.photo, names);
    }
  };
  PipelineResult result;
  try {
    result = RunPipeline(scene, mesh, options, parts);
  } catch (const InputError&) {
    // Nothing to go on from: it would fail again.
    if (!checkpoint.state.has_value()) std::filesystem::remove(checkpoint_path);
    throw;
  }
  result.selection_seconds = selection_seconds;
  for (const std::string& warning : result.selection.warnings) {
    progress.Line("no partner: " + warning);
  }
  CloseParts(mesh, &result, &inputs.parts);
  if (result.closing.has_value()) progress.Line(ClosingLine(*result.closing));
  if (result.trimming.has_value()) progress.Line(TrimText(*result.trimming));
  progress.End();

  WriteSurface(folder, result);
  WriteTextAtomically(folder / "trace.csv", TraceCsv(checkpoint.events));
  WriteTextAtomically(folder / "config.toml", ConfigText(set));
  if (pictures) WritePictures(folder, scene, mesh, result.mesh);
  inputs.cameras = checkpoint.cameras;
  inputs.used = &scene;
  if (options.refinement.cameras.refine != CameraUnknowns::kNone) {
    std::cout << WriteCameras(result.SeenOr(scene), result.refinement.cameras, folder / "cameras");
  } else {
    RemoveCameras(folder);
  }
  nlohmann::ordered_json summary = SummaryJson(inputs, options, result, watch.Seconds());
  const int caught = signals.Caught();
  summary["complete"] = caught == 0;
  WriteTextAtomically(folder / "summary.json", JsonText(summary));
  if (caught != 0) {
    throw Interrupted(caught, (folder / "refined.ply").string() +
                                  " is the mesh so far; to go on: burin refine --resume " +
                                  folder.string());
  }
  std::filesystem::remove(checkpoint_path);
  std::cout << "wrote " << (folder / "refined.ply").string() << ": " << result.mesh.vertices.size()
            << " vertices, " << result.mesh.faces.size() << " faces; "
            << result.selection.pairs.size() << " pairs, " << std::lround(watch.Seconds()) << " s, "
            << std::lround(PeakMemoryMib()) << " MiB\n";
}

}  // namespace

void AddRefineCommand(Program* program) {
  Command command = program->Add("refine", "refine a mesh against its photographs");
  const auto state = std::make_shared<RefineCommand>();
  state->options.Describe(&state->set);
  const std::vector<Argument> sources = command.Scene(&state->source, /*photographs=*/true);
  const Argument mesh = command.Text("--mesh", "FILE", &state->mesh_path,
                                     "mesh to start from: PLY, OBJ, OFF or STL; without it "
                                     "NAME_mesh.ply of NAME.mvs, or one made as by burin mesh");
  const Argument output = command.Text("--output", "DIR (required)", &state->output_path,
                                       "folder for refined.ply, summary.json and trace.csv");
  const Argument pictures =
      command.Flag("--pictures", &state->pictures,
                   "also write before_after.png: the middle view and both meshes seen from it");
  const Argument level_meshes =
      command.Flag("--level-meshes", &state->level_meshes,
                   "also write level_N.ply, the mesh at the end of pyramid level N");
  const Argument debug_images =
      command.Flag("--debug.images", &state->debug_images,
                   "also write debug/: per level and view, the taps its windows keep and its "
                   "first pair's errors with and without masks");
  Argument resume =
      command.Text("--resume", "DIR", &state->resume_path,
                   "instead of all that: go on with the interrupted run in this folder; only "
                   "--run.threads, --memory.limit_gb and where its inputs are now may be given");
  for (const Argument& other :  // and --views, --skip-views
       {output, pictures, level_meshes, debug_images, sources[2], sources[3]}) {
    resume.Excludes(other);
  }
  command.Options(&state->set, {}, [state] { state->options.Check(); });
  command.OnRun([command, state, scene = sources[0], mesh, output, resume] {
    if (resume.Given() && state->resume_path.empty()) {
      throw InputError("--resume: must name a folder");
    }
    if (mesh.Given() && state->mesh_path.empty()) {
      throw InputError("--mesh: must name a file");
    }
    for (const std::string& name : command.Given()) {
      if (name == "--config" || state->set.Find(name.substr(2)) != nullptr) {
        state->given.push_back(name);
      }
    }
    if (!resume.Given()) {
      if (!mesh.Given()) state->mesh_path = MeshBeside(state->source.scene).string();
      if (!scene.Given()) scene.ThrowMissing();
      if (!output.Given()) output.ThrowMissing();
    }
    state->Run();
  });
}

}  // namespace burin
