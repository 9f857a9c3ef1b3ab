// The folder that a command writes its results to, checked before the work instead of after it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace burin {

class OutputFolder {
 public:
  // Makes the folder, with its parents, where it does not exist, and locks it until the end of this
  // object. Throws InputError when the path is something else, cannot be made or cannot be written to,
  // and when another process has locked it.
  explicit OutputFolder(std::filesystem::path path);
  // Folders that the constructor made and that are still empty are removed: a command that fails
  // leaves nothing behind.
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  void RemoveEmpty() const;

  std::filesystem::path path_;
  std::vector<std::filesystem::path> made_;  // innermost first
  int lock_ = -1;                            // descriptor of the folder, locked
};

// An interrupted run needs what it began with: throws InputError where one of `written` is `input`, which is `named`
// so.
void RefuseToReplace(const std::string& named, const std::filesystem::path& input,
                     const std::vector<std::filesystem::path>& written);

}  // namespace burin
