#include "apps/run/checkpoint.h"

// The functions themselves: no library to link, and the state needs no heap.
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <array>
#include <cinttypes>
#include <cstdio>
#include <exception>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "core/support/atomic_file.h"
#include "core/support/cbor.h"
#include "core/support/error.h"
#include "core/support/file_bytes.h"

namespace burin {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CameraPair, reference, second)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(IterationRecord, iteration, energy, gradient_max, step_norm,
                                   accepted, linear_iterations, seconds)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RefinementEvent, level, round, done, iteration, windows)

namespace {

using nlohmann::json;

// Raise it whenever the content of the file changes: a program reads checkpoints of its own version only.
constexpr int kVersion = 11;

std::string Hexadecimal(uint64_t number) {
  char text[24];
  std::snprintf(text, sizeof(text), "%016" PRIx64, number);
  return text;
}

std::string Hash(const std::vector<uint8_t>& bytes) {
  return Hexadecimal(XXH3_64bits(bytes.data(), bytes.size()));
}

}  // namespace

std::string InputsFingerprint(const Scene& scene, const TriangleMesh& mesh) {
  XXH3_state_t hash;
  XXH3_64bits_reset(&hash);
  const auto add = [&hash](const void* data, size_t bytes) {
    XXH3_64bits_update(&hash, data, bytes);
  };
  const auto add_image = [&add](const cv::Mat& image) {
    const std::array<int, 3> shape = {image.rows, image.cols, image.type()};
    add(shape.data(), sizeof(shape));
    for (int row = 0; row < image.rows; ++row) add(image.ptr(row), image.cols * image.elemSize());
  };
  for (const View& view : scene.views) {
    const Eigen::Matrix<double, 3, 4> projection = view.camera.ProjectionMatrix();
    add(projection.data(), sizeof(projection));
    add_image(view.mask);
    add_image(view.gray);
    if (!view.object.empty()) add_image(view.object);
  }
  add(mesh.vertices.data(), mesh.vertices.size() * sizeof(mesh.vertices[0]));
  add(mesh.faces.data(), mesh.faces.size() * sizeof(mesh.faces[0]));
  return Hexadecimal(XXH3_64bits_digest(&hash));
}

std::filesystem::path CheckpointPath(const std::filesystem::path& output_folder) {
  return output_folder / "checkpoint.cbor";
}

std::string MovedPath(const std::string& path, const std::filesystem::path& old_folder,
                      const std::filesystem::path& folder) {
  std::error_code error;
  if (path.empty() || old_folder.empty() || std::filesystem::exists(path, error)) return path;
  const std::filesystem::path now = (std::filesystem::absolute(folder) /
                                     std::filesystem::path(path).lexically_relative(old_folder))
                                        .lexically_normal();
  return std::filesystem::exists(now, error) ? now.string() : path;
}

void PlaceInputs(const Checkpoint& checkpoint, const std::filesystem::path& folder,
                 SceneArguments* source, std::string* mesh_path) {
  const auto place = [&](const std::string& before, std::string* now) {
    if (now->empty()) *now = MovedPath(before, checkpoint.folder, folder);
  };
  place(checkpoint.source.scene, &source->scene);
  place(checkpoint.source.images, &source->images);
  place(checkpoint.source.masks, &source->masks);
  place(checkpoint.mesh_path, mesh_path);
  source->filter = checkpoint.source.filter;
}

void WriteCheckpoint(const std::filesystem::path& path, const Checkpoint& checkpoint) {
  json body = {{"scene", checkpoint.source.scene},
               {"images", checkpoint.source.images},
               {"mesh", checkpoint.mesh_path},
               {"folder", checkpoint.folder},
               {"masks", checkpoint.source.masks},
               {"config", checkpoint.config},
               {"inputs", checkpoint.inputs},
               {"instruction_set", checkpoint.instruction_set},
               {"pictures", checkpoint.pictures},
               {"debug_images", checkpoint.debug_images},
               {"level_meshes", checkpoint.level_meshes},
               {"pairs", checkpoint.pairs},
               {"events", checkpoint.events}};
  const ViewFilter& filter = checkpoint.source.filter;
  if (!filter.views.empty()) body["views"] = filter.views;
  if (!filter.skip.empty()) body["skip_views"] = filter.skip;
  if (!checkpoint.left_out.empty()) body["left_out"] = checkpoint.left_out;
  if (!checkpoint.verdict.empty()) body["verdict"] = checkpoint.verdict;
  if (!checkpoint.cameras.empty()) body["cameras"] = checkpoint.cameras;
  if (checkpoint.state) body["state"] = json::binary(StateBytes(*checkpoint.state));
  std::vector<uint8_t> body_bytes = json::to_cbor(body);
  const json file = {{"burin_checkpoint", kVersion},
                     {"hash", Hash(body_bytes)},
                     {"body", json::binary(std::move(body_bytes))}};
  const std::vector<uint8_t> bytes = json::to_cbor(file);
  WriteTextDurably(path, std::string(bytes.begin(), bytes.end()));
}

Checkpoint ReadCheckpoint(const std::filesystem::path& path) {
  const std::string bytes = ReadFileBytes(path);
  Checkpoint checkpoint;
  try {
    const json file = ReadCbor(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
    if (const int version = file.at("burin_checkpoint"); version != kVersion) {
      throw InputError(path, "version is " + std::to_string(version) + ", must be " +
                                 std::to_string(kVersion) + ": written by another burin");
    }
    const std::vector<uint8_t>& body_bytes = file.at("body").get_binary();
    if (file.at("hash") != Hash(body_bytes)) throw std::runtime_error("its bytes were changed");
    const json body = ReadCbor(body_bytes.data(), body_bytes.size());
    body.at("scene").get_to(checkpoint.source.scene);
    body.at("images").get_to(checkpoint.source.images);
    body.at("mesh").get_to(checkpoint.mesh_path);
    checkpoint.folder = body.value("folder", "");
    body.at("masks").get_to(checkpoint.source.masks);
    checkpoint.source.filter = {body.value("views", ""), body.value("skip_views", "")};
    body.at("config").get_to(checkpoint.config);
    body.at("inputs").get_to(checkpoint.inputs);
    body.at("instruction_set").get_to(checkpoint.instruction_set);
    body.at("pictures").get_to(checkpoint.pictures);
    body.at("debug_images").get_to(checkpoint.debug_images);
    body.at("level_meshes").get_to(checkpoint.level_meshes);
    if (body.contains("left_out")) body["left_out"].get_to(checkpoint.left_out);
    if (body.contains("verdict")) body["verdict"].get_to(checkpoint.verdict);
    if (body.contains("cameras")) body["cameras"].get_to(checkpoint.cameras);
    body.at("pairs").get_to(checkpoint.pairs);
    body.at("events").get_to(checkpoint.events);
    if (body.contains("state")) checkpoint.state = StateFromBytes(body["state"].get_binary());
  } catch (const InputError&) {
    throw;
  } catch (const std::exception& error) {
    throw InputError(path, std::string("is not a checkpoint: ") + error.what());
  }
  return checkpoint;
}

}  // namespace burin
