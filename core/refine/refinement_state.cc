#include "core/refine/refinement_state.h"

#include <cstring>
#include <stdexcept>
#include <type_traits>

#include "core/support/cbor.h"

namespace burin {

// How nlohmann::json is told of structs: it finds these functions by the structs' namespace.
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SolveSummary, usable, initial_energy, final_energy, iterations,
                                   unknowns, linear_solver_seconds, strategy, termination)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(LocalGuardReport, inverted_facets, stretched_edges, far_vertices,
                                   reverted_vertices)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CrossingReport, found, left, taken_back)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RoundSummary, round, solve, energy_initial, energy_final,
                                   windows_initial, windows_final, terms, pair_pixels,
                                   supported_vertices, relaxed_vertices, carried_vertices,
                                   camera_px, guard, crossings, visibility_seconds, build_seconds,
                                   solve_seconds)

template <typename T>
void to_json(nlohmann::json& json, const BeforeAndAfter<T>& counts) {  // NOLINT: nlohmann's name
  json = {counts.before, counts.after};
}
template <typename T>
void from_json(const nlohmann::json& json, BeforeAndAfter<T>& counts) {  // NOLINT: nlohmann's name
  json.at(0).get_to(counts.before);
  json.at(1).get_to(counts.after);
}
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(LevelSummary, level, width, height, views, views_halved_less,
                                   vertices, faces, reached_bound, subdivide_seconds, image_seconds,
                                   held_back, left_out, undone, undone_vertices, remeshed_faces,
                                   remesh_seconds, crossing_facets, back_faces, interrupted, rounds)

// Every bit of it.
void to_json(nlohmann::json& json, const Camera& camera) {  // NOLINT: nlohmann's name
  json = {camera.width, camera.height, camera.fx,        camera.fy,
          camera.cx,    camera.cy,     camera.near_depth};
  for (const double number : camera.rotation.reshaped()) json.push_back(number);
  for (const double number : camera.translation) json.push_back(number);
}
void from_json(const nlohmann::json& json, Camera& camera) {  // NOLINT: nlohmann's name
  json.at(0).get_to(camera.width);
  json.at(1).get_to(camera.height);
  double* const numbers[] = {&camera.fx, &camera.fy, &camera.cx, &camera.cy, &camera.near_depth};
  for (size_t k = 0; k < 5; ++k) json.at(2 + k).get_to(*numbers[k]);
  for (size_t k = 0; k < 9; ++k) json.at(7 + k).get_to(camera.rotation.data()[k]);
  for (size_t k = 0; k < 3; ++k) json.at(16 + k).get_to(camera.translation[static_cast<int>(k)]);
}
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Lens, brown, measured)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RefinementSummary, footprint, first_cameras, cameras, lenses,
                                   levels, seconds)

namespace {

using nlohmann::json;

// The array's memory, in this machine's byte order: a state goes on where it was made.
template <typename T>
json Binary(const std::vector<T>& values) {
  std::vector<uint8_t> bytes(values.size() * sizeof(T));
  if (!bytes.empty())
    std::memcpy(bytes.data(), static_cast<const void*>(values.data()), bytes.size());
  return json::binary(std::move(bytes));
}

template <typename T>
void FromBinary(const json& state, const char* field, std::vector<T>* values) {
  const std::vector<uint8_t>& bytes = state.at(field).get_binary();
  if (bytes.size() % sizeof(T) != 0) {
    throw std::runtime_error(std::string(field) + ": " + std::to_string(bytes.size()) +
                             " bytes are no whole number of elements");
  }
  values->resize(bytes.size() / sizeof(T));
  if (!bytes.empty()) std::memcpy(static_cast<void*>(values->data()), bytes.data(), bytes.size());
}

void CheckSize(const char* field, size_t size, size_t expected) {
  if (size != expected) {
    throw std::runtime_error(std::string(field) + ": has " + std::to_string(size) +
                             " elements, must have " + std::to_string(expected));
  }
}

void CheckIndices(const char* field, const int* begin, size_t count, size_t below) {
  for (size_t k = 0; k < count; ++k) {
    if (begin[k] < 0 || static_cast<size_t>(begin[k]) >= below) {
      throw std::runtime_error(std::string(field) + ": element " + std::to_string(k) + " is " +
                               std::to_string(begin[k]) + ", must be below " +
                               std::to_string(below));
    }
  }
}

}  // namespace

int LevelSummary::TakenBack() const {
  int sum = 0;
  for (const RoundSummary& round : rounds) sum += round.crossings.taken_back;
  return sum;
}

std::vector<uint8_t> StateBytes(const RefinementState& state) {
  return json::to_cbor({{"level", state.level},
                        {"stage", state.stage},
                        {"round", state.round},
                        {"vertices", Binary(state.mesh.vertices)},
                        {"faces", Binary(state.mesh.faces)},
                        {"input_position", Binary(state.input_position)},
                        {"level_start", Binary(state.level_start.vertices)},
                        {"level_start_supported", Binary(state.level_start.was_supported)},
                        {"level_start_cameras", state.level_start.cameras},
                        {"part", Binary(state.part)},
                        {"remesh_vertices", Binary(state.remesh_start.mesh.vertices)},
                        {"remesh_faces", Binary(state.remesh_start.mesh.faces)},
                        {"remesh_input", Binary(state.remesh_start.input_position)},
                        {"remesh_supported", Binary(state.remesh_start.was_supported)},
                        {"order_vertex", Binary(state.order.vertex)},
                        {"order_face", Binary(state.order.face)},
                        {"was_supported", Binary(state.was_supported)},
                        {"summary", state.summary}});
}

RefinementState StateFromBytes(const std::vector<uint8_t>& bytes) {
  const json read = ReadCbor(bytes.data(), bytes.size());
  RefinementState state;
  read.at("level").get_to(state.level);
  read.at("stage").get_to(state.stage);
  read.at("round").get_to(state.round);
  FromBinary(read, "vertices", &state.mesh.vertices);
  FromBinary(read, "faces", &state.mesh.faces);
  FromBinary(read, "input_position", &state.input_position);
  FromBinary(read, "level_start", &state.level_start.vertices);
  FromBinary(read, "level_start_supported", &state.level_start.was_supported);
  read.at("level_start_cameras").get_to(state.level_start.cameras);
  FromBinary(read, "part", &state.part);
  RemeshStart& remesh = state.remesh_start;
  FromBinary(read, "remesh_vertices", &remesh.mesh.vertices);
  FromBinary(read, "remesh_faces", &remesh.mesh.faces);
  FromBinary(read, "remesh_input", &remesh.input_position);
  FromBinary(read, "remesh_supported", &remesh.was_supported);
  FromBinary(read, "order_vertex", &state.order.vertex);
  FromBinary(read, "order_face", &state.order.face);
  FromBinary(read, "was_supported", &state.was_supported);
  read.at("summary").get_to(state.summary);
  const size_t vertices = state.mesh.vertices.size();
  const size_t faces = state.mesh.faces.size();
  CheckSize("input_position", state.input_position.size(), vertices);
  CheckSize("was_supported", state.was_supported.size(), vertices);
  const size_t cameras = state.summary.cameras.size();
  CheckSize("first_cameras", state.summary.first_cameras.size(), cameras);
  if (!state.summary.lenses.empty()) CheckSize("lenses", state.summary.lenses.size(), cameras);
  if (faces > 0) CheckIndices("faces", state.mesh.faces[0].data(), 3 * faces, vertices);
  if (!state.part.empty()) CheckSize("part", state.part.size(), vertices);
  const size_t remeshed = remesh.mesh.vertices.size();
  CheckSize("remesh_input", remesh.input_position.size(), remeshed);
  CheckSize("remesh_supported", remesh.was_supported.size(), remeshed);
  if (!remesh.mesh.faces.empty()) {
    CheckIndices("remesh_faces", remesh.mesh.faces[0].data(), 3 * remesh.mesh.faces.size(),
                 remeshed);
  }
  if (state.round > 0) {
    CheckSize("level_start", state.level_start.vertices.size(), vertices);
    CheckSize("level_start_cameras", state.level_start.cameras.size(), cameras);
    CheckSize("level_start_supported", state.level_start.was_supported.size(), vertices);
    CheckSize("order_vertex", state.order.vertex.size(), vertices);
    CheckSize("order_face", state.order.face.size(), faces);
    CheckIndices("order_vertex", state.order.vertex.data(), vertices, vertices);
    CheckIndices("order_face", state.order.face.data(), faces, faces);
  }
  return state;
}

}  // namespace burin
