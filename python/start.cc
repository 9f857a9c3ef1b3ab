#include "python/start.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <exception>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/scene/scene.h"
#include "core/support/error.h"
#include "core/support/parallel.h"
#include "python/arrays.h"
#include "python/options.h"
#include "reconstruct/start_mesh.h"

namespace py = pybind11;

namespace burin {
namespace {

// `given`: options by their names without "start.", as text.
StartOptions OptionsOf(const std::map<std::string, std::string>& given) {
  StartOptions options;
  OptionSet set;
  options.Describe(&set);
  for (const auto& [name, text] : given) {
    Option* option = set.Find("start." + name);
    if (option == nullptr) throw InputError("start." + name + ": there is no such option");
    std::string error;
    if (!option->Set(text, &error) || !option->Check(&error)) throw InputError(error);
  }
  return options;
}

// Python's signal handlers run between the stages and the pieces of them; what they raise is raised again at the end.
py::tuple Mesh(const Scene& scene, const std::map<std::string, std::string>& given, int threads) {
  const StartOptions options = OptionsOf(given);
  std::vector<std::string> lines;
  std::exception_ptr raised;
  StartObservers observers;
  observers.on_line = [&](const std::string& line) { lines.push_back(line); };
  observers.check_stop = [&] {
    const py::gil_scoped_acquire acquire;
    try {
      if (!raised && PyErr_CheckSignals() != 0) throw py::error_already_set();
    } catch (...) {
      raised = std::current_exception();
    }
    if (raised) throw std::runtime_error("stopped");
  };
  StartMesh start;
  try {
    WithoutGil([&] {
      const ThreadScope scope(threads);
      start = MakeStartMesh(scene, options, observers);
    });
  } catch (...) {
    if (!raised) throw;
  }
  if (raised) std::rethrow_exception(raised);
  return py::make_tuple(Array(start.mesh.vertices), Array(start.mesh.faces), Array(start.sights),
                        lines);
}

}  // namespace

void DefineStart(py::module_* module) {
  module->def("mesh", &Mesh, py::arg("scene"), py::arg("options"), py::arg("threads"));
}

}  // namespace burin
