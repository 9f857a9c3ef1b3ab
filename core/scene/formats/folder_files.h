// Lists the files of a folder whose names end in a given way.
#pragma once

#include <algorithm>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

namespace burin {

inline bool EndsIn(const std::string& name, const std::string& ending) {
  return name.size() > ending.size() &&
         name.compare(name.size() - ending.size(), ending.size(), ending) == 0;
}

// In ascending order of name; none when `folder` is no folder.
inline std::vector<std::filesystem::path> FilesEndingIn(const std::filesystem::path& folder,
                                                        const std::string& ending) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  for (std::filesystem::directory_iterator it(folder, error), end; !error && it != end;
       it.increment(error)) {
    if (EndsIn(it->path().filename().string(), ending)) files.push_back(it->path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace burin
