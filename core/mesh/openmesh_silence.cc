#include "core/mesh/openmesh_silence.h"

#include <OpenMesh/Core/System/omstream.hh>

namespace burin {
namespace {

std::mutex& TheMutex() {
  static auto* mutex = new std::mutex();
  return *mutex;
}

}  // namespace

OpenMeshSilence::OpenMeshSilence() : lock_(TheMutex()), was_enabled_(omerr().is_enabled()) {
  omerr().disable();
}

OpenMeshSilence::~OpenMeshSilence() {
  if (was_enabled_) omerr().enable();
}

}  // namespace burin
