#include "core/scene/formats/view_names.h"

#include <algorithm>
#include <iterator>
#include <system_error>

#include "core/support/error.h"
#include "core/support/spelling.h"

namespace burin {
namespace {

namespace fs = std::filesystem;

void CheckName(const std::string& name, const fs::path& file) {
  const bool control = std::any_of(name.begin(), name.end(), [](char c) {
    return static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
  });
  if (control) throw InputError(file, "image '" + name + "': the name has a control character");
  if (fs::path(name).filename().empty() || fs::path(name).filename() == "..") {
    throw InputError(file, "image '" + name + "': is no name of a file");
  }
}

bool Leaves(const fs::path& name) { return name.is_absolute() || *name.begin() == ".."; }

// The parts of a normal path that name something inside.
std::vector<fs::path> PartsInside(const fs::path& name) {
  std::vector<fs::path> parts;
  for (const fs::path& part : name.relative_path()) {
    if (part != "..") parts.push_back(part);
  }
  return parts;
}

}  // namespace

std::vector<std::string> SettledNames(const std::vector<std::string>& names, const fs::path& file,
                                      bool without_common) {
  bool strip = without_common;
  std::vector<std::vector<fs::path>> parts;
  for (std::string name : names) {
    std::replace(name.begin(), name.end(), '\\', '/');
    CheckName(name, file);
    const fs::path normal = fs::path(name).lexically_normal();
    strip = strip || Leaves(normal);
    parts.push_back(PartsInside(normal));
  }
  size_t common = 0;
  const auto all_share = [&parts](size_t k) {
    return std::all_of(parts.begin(), parts.end(), [&](const std::vector<fs::path>& name) {
      return k + 1 < name.size() && name[k] == parts[0][k];
    });
  };
  while (strip && all_share(common)) ++common;
  std::vector<std::string> settled;
  for (const std::vector<fs::path>& name : parts) {
    fs::path path;
    for (size_t k = common; k < name.size(); ++k) path /= name[k];
    settled.push_back(path.generic_string());
  }
  return settled;
}

void SettleNames(PosedScene* posed) {
  std::vector<std::string> names;
  names.reserve(posed->images.size());
  for (const PosedImage& image : posed->images) names.push_back(image.name);
  names = SettledNames(names, posed->file);
  for (size_t i = 0; i < names.size(); ++i) posed->images[i].name = names[i];
}

fs::path FindPhotographBelow(const std::string& name, const fs::path& folder) {
  const std::vector<fs::path> parts = PartsInside(fs::path(name).lexically_normal());
  for (size_t first = 0; first + 1 < parts.size(); ++first) {
    fs::path path = folder;
    for (size_t k = first; k < parts.size(); ++k) path /= parts[k];
    path = AsSpelled(path);
    std::error_code error;
    if (fs::is_regular_file(path, error)) return path;
  }
  return FindPhotograph(fs::path(name).filename().string(), {folder});
}

std::string WithExtension(const std::string& name, const std::vector<fs::path>& places) {
  for (const char* extension :
       {"", ".png", ".jpg", ".jpeg", ".tif", ".PNG", ".JPG", ".JPEG", ".TIF"}) {
    for (const fs::path& place : places) {
      std::error_code error;
      if (fs::is_regular_file(place.string() + extension, error)) return name + extension;
    }
  }
  return name;
}

}  // namespace burin
