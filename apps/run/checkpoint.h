// checkpoint.cbor in a run's output folder: `burin refine --resume` goes on from it. The file is there
// from before the first round until the run is complete, and it is always whole.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/run/scene_arguments.h"
#include "core/mesh/mesh.h"
#include "core/refine/refinement.h"
#include "core/scene/pairs.h"
#include "core/scene/scene.h"

namespace burin {

struct Checkpoint {
  SceneArguments source;        // absolute
  std::string mesh_path;        // absolute
  std::string folder;           // of the run when this was written, absolute
  std::string config;           // every option, as TOML
  std::string inputs;           // InputsFingerprint
  std::string instruction_set;  // KernelInstructionSet of the machine that wrote the state
  bool pictures = false;
  bool debug_images = false;
  bool level_meshes = false;
  std::vector<std::string> left_out;     // views by name (scene.misfit)
  std::string verdict;                   // as summary.json has it; empty = not judged
  std::vector<CameraPair> pairs;         // of the views that are left
  std::string cameras;                   // TrackStepJson; empty = cameras are not refined
  std::vector<RefinementEvent> events;   // the trace so far
  std::optional<RefinementState> state;  // after the last finished round; none before the first
};

// Tells changed inputs apart: XXH3 of cameras, masks, grey images and mesh, in hexadecimal.
std::string InputsFingerprint(const Scene& scene, const TriangleMesh& mesh);

std::filesystem::path CheckpointPath(const std::filesystem::path& output_folder);

void WriteCheckpoint(const std::filesystem::path& path, const Checkpoint& checkpoint);

// Where `path` of a checkpoint is now: itself where it exists; else, in a run that was moved together with its inputs from
// `old_folder` to `folder`, what has its place beside the new one where that exists; else itself.
std::string MovedPath(const std::string& path, const std::filesystem::path& old_folder,
                      const std::filesystem::path& folder);

// Scene and mesh of a run that goes on in `folder`: where the arguments say, and MovedPath of the checkpoint's for those that
// are empty.
void PlaceInputs(const Checkpoint& checkpoint, const std::filesystem::path& folder,
                 SceneArguments* source, std::string* mesh_path);

// Throws InputError when the file is missing or is not a checkpoint.
Checkpoint ReadCheckpoint(const std::filesystem::path& path);

}  // namespace burin
