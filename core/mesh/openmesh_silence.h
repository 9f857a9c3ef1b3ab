// OpenMesh reports to one stream of the process, and its readers are singletons that keep state.
#pragma once

#include <mutex>

namespace burin {

// While it lives OpenMesh prints nothing, and other threads that want one wait.
class OpenMeshSilence {
 public:
  OpenMeshSilence();
  ~OpenMeshSilence();
  OpenMeshSilence(const OpenMeshSilence&) = delete;
  OpenMeshSilence& operator=(const OpenMeshSilence&) = delete;

 private:
  const std::lock_guard<std::mutex> lock_;
  const bool was_enabled_;
};

}  // namespace burin
