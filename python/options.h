// Options by name for Python, and what every call of python/module.cc needs.
#pragma once

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <string>
#include <variant>
#include <vector>

#include "apps/run/pipeline.h"
#include "core/support/error.h"

namespace burin {

namespace py = pybind11;

// Other Python threads run during the call.
template <typename Call>
auto WithoutGil(const Call& call) {
  const py::gil_scoped_release release;
  return call();
}

// Options as the C++ structs have them; Python names them by OptionSet.
struct Options {
  Options() { options.Describe(&set); }
  Options(const Options& other) : options(other.options) { options.Describe(&set); }
  Options& operator=(const Options&) = delete;

  std::vector<std::string> Names() const {
    std::vector<std::string> names;
    for (const Option& option : set.options()) names.push_back(option.name);
    return names;
  }
  Option& At(const std::string& name) {
    Option* option = set.Find(name);
    if (option == nullptr) throw py::key_error(name + ": there is no option of this name");
    return *option;
  }
  py::object Get(const std::string& name) {
    return At(name).Visit([](const auto& value) -> py::object { return py::cast(value); });
  }
  void Set(const std::string& name, const py::object& value) {
    Option& option = At(name);
    const bool is_bool = std::holds_alternative<bool*>(option.value);
    const bool is_text = option.IsText();
    if (is_bool != py::isinstance<py::bool_>(value) || is_text != py::isinstance<py::str>(value) ||
        (!is_bool && !is_text && PyNumber_Check(value.ptr()) == 0)) {
      throw py::type_error(name + ": must be " + option.Constraint());
    }
    std::string error;
    const std::string text =
        is_bool ? (value.cast<bool>() ? "true" : "false") : py::str(value).cast<std::string>();
    const std::string before = option.Text();
    if (option.Set(text, &error)) return;
    std::string ignored;
    option.Set(before, &ignored);
    throw InputError(error);
  }

  PipelineOptions options;
  OptionSet set;
};

inline py::object ParseJson(const std::string& text) {
  return py::module_::import("json").attr("loads")(text);
}

}  // namespace burin
