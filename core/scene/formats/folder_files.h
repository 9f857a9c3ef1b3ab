// Lists the files of a folder whose names end in a given way, and its photographs.
#pragma once

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <initializer_list>
#include <string>
#include <system_error>
#include <vector>

namespace burin {

inline bool EndsIn(const std::string& name, const std::string& ending) {
  return name.size() > ending.size() &&
         name.compare(name.size() - ending.size(), ending.size(), ending) == 0;
}

// `path` where it is a file with this extension, else the first of `names` that is a file in the folder `path`; empty where
// there is none.
inline std::filesystem::path FileOrInFolder(const std::filesystem::path& path,
                                            const std::string& extension,
                                            std::initializer_list<const char*> names) {
  std::error_code error;
  if (path.extension() == extension && std::filesystem::is_regular_file(path, error)) return path;
  for (const char* name : names) {
    if (std::filesystem::is_regular_file(path / name, error)) return path / name;
  }
  return {};
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

// PNG, JPEG and TIFF by their extensions, in either case, in ascending order of name.
inline std::vector<std::filesystem::path> PhotographsIn(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> photographs;
  for (const std::filesystem::path& file : FilesEndingIn(folder, "")) {
    std::string extension = file.extension().string();
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    for (const char* known : {".png", ".jpg", ".jpeg", ".tif", ".tiff"}) {
      if (extension == known) photographs.push_back(file);
    }
  }
  return photographs;
}

}  // namespace burin
