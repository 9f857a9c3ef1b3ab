#include "apps/run/checkpoint.h"

#include <cstdio>
#include <exception>
#include <functional>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "core/support/atomic_file.h"
#include "core/support/cbor.h"
#include "core/support/error.h"
#include "core/support/file_bytes.h"

namespace burin {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CameraPair, reference, second)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(IterationRecord, iteration, energy, gradient_max, step_norm,
                                   accepted, linear_iterations, seconds)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RefinementEvent, level, round, done, iteration)

namespace {

using nlohmann::json;

// Raise it whenever the content of the file changes: a program reads checkpoints of its own version only.
constexpr int kVersion = 2;

class Fingerprint {
 public:
  void Add(const void* data, size_t bytes) {
    const size_t hash =
        std::hash<std::string_view>()(std::string_view(static_cast<const char*>(data), bytes));
    value_ = (value_ ^ hash) * 0x9E3779B97F4A7C15U;
    value_ ^= value_ >> 29U;
  }
  std::string Text() const {
    char text[24];
    std::snprintf(text, sizeof(text), "%016zx", value_);
    return text;
  }

 private:
  size_t value_ = 0;
};

}  // namespace

std::string InputsFingerprint(const Scene& scene, const TriangleMesh& mesh) {
  Fingerprint fingerprint;
  for (const View& view : scene.views) {
    const Eigen::Matrix<double, 3, 4> projection = view.camera.ProjectionMatrix();
    fingerprint.Add(projection.data(), sizeof(projection));
    for (int row = 0; row < view.mask.rows; ++row) {
      fingerprint.Add(view.mask.ptr(row), view.mask.cols);
    }
    for (int row = 0; row < view.gray.rows; ++row) {
      fingerprint.Add(view.gray.ptr(row), view.gray.cols * view.gray.elemSize());
    }
  }
  fingerprint.Add(mesh.vertices.data(), mesh.vertices.size() * sizeof(mesh.vertices[0]));
  fingerprint.Add(mesh.faces.data(), mesh.faces.size() * sizeof(mesh.faces[0]));
  return fingerprint.Text();
}

std::filesystem::path CheckpointPath(const std::filesystem::path& output_folder) {
  return output_folder / "checkpoint.cbor";
}

void WriteCheckpoint(const std::filesystem::path& path, const Checkpoint& checkpoint) {
  json body = {{"scene", checkpoint.source.scene},
               {"images", checkpoint.source.images},
               {"mesh", checkpoint.mesh_path},
               {"masks", checkpoint.source.masks},
               {"config", checkpoint.config},
               {"inputs", checkpoint.inputs},
               {"pictures", checkpoint.pictures},
               {"debug_images", checkpoint.debug_images},
               {"level_meshes", checkpoint.level_meshes},
               {"pairs", checkpoint.pairs},
               {"events", checkpoint.events}};
  if (checkpoint.state) body["state"] = json::binary(StateBytes(*checkpoint.state));
  std::vector<uint8_t> body_bytes = json::to_cbor(body);
  Fingerprint hash;
  hash.Add(body_bytes.data(), body_bytes.size());
  const json file = {{"burin_checkpoint", kVersion},
                     {"hash", hash.Text()},
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
    Fingerprint hash;
    hash.Add(body_bytes.data(), body_bytes.size());
    if (file.at("hash") != hash.Text()) throw std::runtime_error("its bytes were changed");
    const json body = ReadCbor(body_bytes.data(), body_bytes.size());
    body.at("scene").get_to(checkpoint.source.scene);
    body.at("images").get_to(checkpoint.source.images);
    body.at("mesh").get_to(checkpoint.mesh_path);
    body.at("masks").get_to(checkpoint.source.masks);
    body.at("config").get_to(checkpoint.config);
    body.at("inputs").get_to(checkpoint.inputs);
    body.at("pictures").get_to(checkpoint.pictures);
    body.at("debug_images").get_to(checkpoint.debug_images);
    body.at("level_meshes").get_to(checkpoint.level_meshes);
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
