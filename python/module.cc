// burin as a Python module: NumPy arrays in and out, the GIL released while burin works. What users see
// is python/burin/__init__.py; this file only converts.
#include <pybind11/eigen.h>
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <exception>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "apps/run/judged_scene.h"
#include "apps/run/level_energy.h"
#include "apps/run/pipeline.h"
#include "apps/run/run_output.h"
#include "apps/run/verdict_output.h"
#include "core/mesh/mesh_io.h"
#include "core/scene/doubts.h"
#include "core/scene/formats/camera_checks.h"
#include "core/scene/formats/scene_loader.h"
#include "core/scene/formats/view_names.h"
#include "core/support/error.h"
#include "core/support/json_file.h"
#include "core/support/parallel.h"
#include "core/support/stopwatch.h"
#include "python/arrays.h"
#include "python/options.h"
#include "python/start.h"

namespace py = pybind11;

namespace burin {
namespace {

using Path = std::filesystem::path;
constexpr double kMostGrey = 1e6;

// A scene from arrays: images (H, W) of grey levels, K, R, t as burin's conventions have them.
Scene SceneOf(const std::vector<std::string>& names, const std::vector<py::array>& images,
              const std::vector<Eigen::Matrix3d>& intrinsics,
              const std::vector<Eigen::Matrix3d>& rotations,
              const std::vector<Eigen::Vector3d>& translations) {
  const size_t count = names.size();
  if (images.size() != count || intrinsics.size() != count || rotations.size() != count ||
      translations.size() != count) {
    throw InputError("names, images, intrinsics, rotations and translations: must be as many");
  }
  Scene scene;
  for (size_t i = 0; i < count; ++i) {
    const std::string element = "image " + names[i] + ": ";
    if (images[i].ndim() != 2 || images[i].size() == 0) {
      throw InputError(element + "must be an array of shape (H, W)");
    }
    if (std::string("fiu").find(images[i].dtype().kind()) == std::string::npos) {
      throw InputError(element + "must be real numbers");
    }
    View& view = scene.views.emplace_back();
    view.name = names[i];
    const int rows = static_cast<int>(images[i].shape(0));
    const int columns = static_cast<int>(images[i].shape(1));
    if (py::isinstance<py::array_t<uint8_t>>(images[i])) {
      const py::array_t<uint8_t, py::array::c_style | py::array::forcecast> data(images[i]);
      view.gray = cv::Mat(rows, columns, CV_8UC1, const_cast<uint8_t*>(data.data())).clone();
    } else {
      const py::array_t<float, py::array::c_style | py::array::forcecast> data(images[i]);
      view.gray = cv::Mat(rows, columns, CV_32FC1, const_cast<float*>(data.data())).clone();
      if (!cv::checkRange(view.gray, true, nullptr, -kMostGrey, kMostGrey)) {
        throw InputError(element + "grey levels must be finite and within 1e6");
      }
    }
    view.camera = CameraOfIntrinsics(intrinsics[i], 0.5, names[i], "intrinsics");
    view.camera.width = columns;
    view.camera.height = rows;
    view.camera.rotation = NearestRotation(rotations[i], names[i], "rotation");
    view.camera.translation = translations[i];
  }
  SettledNames(names, "scene");  // throws for what is no name
  if (std::set<std::string>(names.begin(), names.end()).size() != count) {
    throw InputError("names: one appears twice");
  }
  CheckCameras(scene.views, "scene");
  CheckCentresDiffer(scene.views, "scene");
  return scene;
}

std::vector<std::string> NamesOf(const Scene& scene) {
  std::vector<std::string> names;
  for (const View& view : scene.views) names.push_back(view.name);
  return names;
}

Eigen::Matrix3d IntrinsicsOf(const Camera& camera) {
  Eigen::Matrix3d k;
  k << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
  return k;
}

// Rotations (V, 3, 3) and translations (V, 3).
py::tuple PoseArrays(const std::vector<Camera>& cameras) {
  std::vector<Eigen::Matrix3d> rotations;
  std::vector<Eigen::Vector3d> translations;
  for (const Camera& camera : cameras) {
    rotations.push_back(camera.rotation);
    translations.push_back(camera.translation);
  }
  return py::make_tuple(Array(rotations), Array(translations));
}

py::dict EventDict(const RefinementEvent& event) {
  py::dict dict;
  dict["level"] = event.level;
  dict["round"] = event.round;
  dict["done"] = event.done;
  dict["iteration"] = event.iteration.iteration;
  dict["energy"] = event.iteration.energy;
  dict["gradient_max"] = event.iteration.gradient_max;
  dict["step_norm"] = event.iteration.step_norm;
  dict["accepted"] = event.iteration.accepted;
  return dict;
}

// A RuntimeWarning, which Python may have been told to raise.
void Warn(const std::string& line) {
  if (PyErr_WarnEx(PyExc_RuntimeWarning, line.c_str(), 2) != 0) throw py::error_already_set();
}

py::dict SurfaceDict(const TriangleMesh& mesh, const std::vector<VertexScalar>& scalars) {
  py::dict quality;
  for (const VertexScalar& scalar : scalars) quality[scalar.name.c_str()] = Array(scalar.values);
  py::dict surface;
  surface["vertices"] = Array(mesh.vertices);
  surface["faces"] = Array(mesh.faces);
  surface["quality"] = quality;
  return surface;
}

// Python's signal handlers run between iterations, so that Ctrl-C ends a refinement; what they or the
// callback raise is raised again when the refinement has ended.
py::dict RefineMesh(const Scene& scene, const py::array& vertices, const py::array& faces,
                    Options* given, const py::object& callback) {
  TriangleMesh mesh = MeshOf(vertices, faces);
  const PipelineOptions options = given->options;
  RunInputs inputs;
  inputs.command_line = "burin.refine";
  inputs.scene = &scene;
  inputs.mesh = &mesh;
  const Stopwatch watch;
  std::exception_ptr raised;
  PipelineParts parts;
  parts.observers.on_iteration = [&](const RefinementEvent& event) {
    const py::gil_scoped_acquire acquire;
    try {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (callback.is_none()) return true;
      const py::object answer = callback(EventDict(event));
      if (answer.is_none()) return true;
      const int goes_on = PyObject_IsTrue(answer.ptr());
      if (goes_on < 0) throw py::error_already_set();
      return goes_on == 1;
    } catch (...) {
      raised = std::current_exception();
      return false;
    }
  };
  PipelineResult result;
  JudgedScene judged;
  WithoutGil([&] {
    options.Check();
    inputs.memory = CheckMemory(scene, mesh, options);
    inputs.parts = OrientAndCheck(scene, options.mesh, "mesh", &mesh);
    judged = JudgeAndSelect(scene, mesh, options);
  });
  if (judged.judged) {
    inputs.verdict = JsonText(VerdictJson(judged.verdict, scene, judged.left_out));
    inputs.verdict_seconds = judged.seconds;
  }
  for (const std::string& line : inputs.parts.lines) Warn(line);
  for (const std::string& line : judged.lines) Warn(line);
  if (judged.stop) {
    Warn("this cannot be right: " + judged.verdict.reason + "; the input mesh is the result");
    result.mesh = mesh;
    result.selection = judged.selection;
  } else {
    parts.selection = &judged.selection;
    parts.by_tracks = judged.by_tracks.has_value() ? &*judged.by_tracks : nullptr;
    inputs.used = &judged.Used(scene);
    WithoutGil([&] { result = RunPipeline(judged.Used(scene), mesh, options, parts); });
  }
  if (raised) std::rethrow_exception(raised);
  CloseParts(mesh, &result, &inputs.parts);
  py::dict out = SurfaceDict(result.mesh, result.quality);
  out["whole"] = py::none();
  if (result.trimming.has_value()) {
    py::dict whole = SurfaceDict(result.trimming->whole, result.trimming->quality);
    std::vector<std::string> reasons;
    for (const CutReason reason : result.trimming->reasons) reasons.push_back(NameOf(reason));
    whole["cut"] = reasons;
    out["whole"] = whole;
  }
  std::vector<Eigen::Matrix3d> intrinsics;
  for (const Camera& camera : result.refinement.cameras) intrinsics.push_back(IntrinsicsOf(camera));
  const py::tuple poses = PoseArrays(result.refinement.cameras);
  py::dict cameras;
  cameras["names"] = NamesOf(judged.Used(scene));
  cameras["intrinsics"] = Array(intrinsics);
  cameras["rotations"] = poses[0];
  cameras["translations"] = poses[1];
  out["cameras"] = cameras;
  out["summary"] = ParseJson(JsonText(SummaryJson(inputs, options, result, watch.Seconds())));
  return out;
}

py::object Check(const Scene& scene, const py::array& vertices, const py::array& faces,
                 Options* options) {
  TriangleMesh mesh = MeshOf(vertices, faces);
  const PipelineOptions given = options->options;
  return ParseJson(WithoutGil([&] {
    given.Check();
    const ThreadScope threads(given.threads);
    const MeshParts parts = OrientAndCheck(scene, given.mesh, "mesh", &mesh);
    PairSelection selection;
    double seconds = 0;
    return JsonText(
        CheckJson(SelectAndJudge(scene, mesh, given.pairs, &selection, &seconds), scene, parts));
  }));
}

py::dict Select(const Scene& scene, const py::array& vertices, const py::array& faces,
                Options* options) {
  const TriangleMesh mesh = MeshOf(vertices, faces);
  const PipelineOptions given = options->options;
  PairSelection selection;
  {
    const py::gil_scoped_release release;
    given.Check();
    const ThreadScope threads(given.threads);
    selection = SelectPairs(scene, mesh, given.pairs);
  }
  py::dict out;
  out["pairs"] = PairTuples(selection.pairs);
  out["held_back"] = PairTuples(selection.held_back);
  out["warnings"] = selection.warnings;
  return out;
}

py::tuple Linearize(LevelEnergy* energy, const Eigen::VectorXd& x) {
  double value = 0;
  Eigen::VectorXd gradient;
  const SymmetricMatrix matrix =
      WithoutGil([&] { return energy->Linearize(x, &value, &gradient); });
  return py::make_tuple(value, gradient, Array(matrix.value), Array(matrix.column),
                        Array(matrix.start));
}

void DefineScene(py::module_* module) {
  py::class_<Scene, std::shared_ptr<Scene>>(*module, "Scene")
      .def(py::init(&SceneOf), py::arg("names"), py::arg("images"), py::arg("intrinsics"),
           py::arg("rotations"), py::arg("translations"))
      .def("__len__", [](const Scene& scene) { return scene.views.size(); })
      .def_property_readonly("names", &NamesOf)
      .def("image",
           [](const Scene& scene, size_t view) -> py::array {
             const cv::Mat& gray = scene.views.at(view).gray;
             if (gray.type() == CV_8UC1) return ImageArray<uint8_t>(gray);
             return ImageArray<float>(gray);
           })
      .def("intrinsics", [](const Scene& scene,
                            size_t view) { return IntrinsicsOf(scene.views.at(view).camera); })
      .def("rotation",
           [](const Scene& scene, size_t view) { return scene.views.at(view).camera.rotation; })
      .def("translation",
           [](const Scene& scene, size_t view) { return scene.views.at(view).camera.translation; })
      .def_property_readonly("points", [](const Scene& scene) {
        std::vector<Eigen::Vector3d> points;
        for (const ScenePoint& point : scene.points) points.push_back(point.position);
        return Array(points);
      });
  module->def(
      "load_scene",
      [](const Path& path, const Path& images, const Path& masks) {
        return std::make_shared<Scene>(LoadScene({path, images, masks}));
      },
      py::arg("path"), py::arg("images"), py::arg("masks"),
      py::call_guard<py::gil_scoped_release>());
  module->def("doubts_about", &DoubtsAbout, py::arg("scene"));
}

void DefineOptions(py::module_* module) {
  py::class_<Options>(*module, "Options")
      .def(py::init<>())
      .def(py::init<const Options&>())
      .def("names", &Options::Names)
      .def("get", &Options::Get)
      .def("set", &Options::Set)
      .def("help", [](Options* options, const std::string& name) { return options->At(name).help; })
      .def("constraint",
           [](Options* options, const std::string& name) { return options->At(name).Constraint(); })
      .def("check", [](const Options& options) { options.options.Check(); });
}

void DefineEnergy(py::module_* module) {
  py::class_<LevelEnergy>(*module, "Energy")
      .def(py::init([](const Scene& scene, const py::array& vertices, const py::array& faces,
                       const std::vector<std::pair<int, int>>& pairs, Options* options, int level,
                       bool cameras) {
             const TriangleMesh mesh = MeshOf(vertices, faces);
             const PipelineOptions given = options->options;
             const py::gil_scoped_release release;
             return std::make_unique<LevelEnergy>(scene, mesh, PairsOf(pairs), given, level,
                                                  cameras);
           }),
           py::arg("scene"), py::arg("vertices"), py::arg("faces"), py::arg("pairs"),
           py::arg("options"), py::arg("level"), py::arg("cameras"))
      .def_property_readonly("unknowns", &LevelEnergy::unknowns)
      .def_property_readonly("footprint", &LevelEnergy::footprint)
      .def_property_readonly(
          "vertex_of_unknown",
          [](const LevelEnergy& energy) { return Array(energy.vertex_of_unknown()); })
      .def_property_readonly(
          "camera_of_unknown",
          [](const LevelEnergy& energy) { return Array(energy.camera_of_unknown()); })
      .def_property_readonly("normals",
                             [](const LevelEnergy& energy) { return Array(energy.normals()); })
      .def("evaluate",
           [](LevelEnergy* energy, const Eigen::VectorXd& x) {
             Eigen::VectorXd gradient;
             const double value = WithoutGil([&] { return energy->Evaluate(x, &gradient); });
             return py::make_tuple(value, gradient);
           })
      .def("linearize", &Linearize)
      .def("terms",
           [](LevelEnergy* energy, const Eigen::VectorXd& x) {
             return ParseJson(WithoutGil([&] { return energy->Terms(x).dump(); }));
           })
      .def("vertices_at",
           [](const LevelEnergy& energy, const Eigen::VectorXd& x) {
             return Array(WithoutGil([&] { return energy.VerticesAt(x); }));
           })
      .def("cameras_at",
           [](const LevelEnergy& energy, const Eigen::VectorXd& x) {
             return PoseArrays(WithoutGil([&] { return energy.CamerasAt(x); }));
           })
      .def("kept_taps",
           [](LevelEnergy* energy, int view) {
             return ImageArray<int>(WithoutGil([&] { return energy->KeptTaps(view); }));
           })
      .def("solve", [](LevelEnergy* energy, const std::string& strategy) {
        const LevelEnergy::Solution solution = WithoutGil([&] { return energy->Solve(strategy); });
        py::dict out;
        out["x"] = solution.x;
        out["energy"] = solution.energy;
        out["iterations"] = solution.iterations;
        out["evaluations"] = solution.evaluations;
        out["termination"] = solution.termination;
        return out;
      });
}

}  // namespace
}  // namespace burin

PYBIND11_MODULE(_burin, module) {
  using namespace burin;  // NOLINT(google-build-using-namespace)
  py::register_exception<InputError>(module, "InputError", PyExc_ValueError);
  py::register_exception<MemoryLimitError>(module, "MemoryLimitError", PyExc_MemoryError);
  DefineOptions(&module);
  DefineScene(&module);
  DefineEnergy(&module);
  DefineStart(&module);
  module.def("read_mesh", [](const Path& path) {
    const TriangleMesh mesh = WithoutGil([&] { return ReadMesh(path); });
    return py::make_tuple(Array(mesh.vertices), Array(mesh.faces));
  });
  module.def("write_mesh", [](const Path& path, const py::array& vertices, const py::array& faces) {
    const TriangleMesh mesh = MeshOf(vertices, faces);
    WithoutGil([&] { WriteMesh(path, mesh); });
  });
  module.def("refine", &RefineMesh, py::arg("scene"), py::arg("vertices"), py::arg("faces"),
             py::arg("options"), py::arg("callback"));
  module.def("check", &Check, py::arg("scene"), py::arg("vertices"), py::arg("faces"),
             py::arg("options"));
  module.def("select_pairs", &Select, py::arg("scene"), py::arg("vertices"), py::arg("faces"),
             py::arg("options"));
  module.def("strategies", [] {
    std::vector<std::string> names;
    for (const Strategy& strategy : Strategies()) names.push_back(strategy.name);
    return names;
  });
}
