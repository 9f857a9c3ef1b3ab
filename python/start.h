// burin.mesh: a mesh to start from.
#pragma once

#include <pybind11/pybind11.h>

namespace burin {

void DefineStart(pybind11::module_* module);

}  // namespace burin
