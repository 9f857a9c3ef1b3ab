#include "core/scene/formats/mask_files.h"

#include <set>
#include <system_error>

#include "core/support/error.h"
#include "core/support/fixed_text.h"
#include "core/support/spelling.h"

namespace burin {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPictures[] = {".png",  ".jpg", ".jpeg", ".tif",
                                     ".tiff", ".bmp", ".pgm",  ".webp"};

// What the mask of `name` may be called, as keys, in the order in which they count.
std::vector<std::string> MaskNames(const fs::path& name) {
  const fs::path folder = name.parent_path();
  const std::string stem = name.stem().string();
  std::vector<fs::path> names = {name.string() + ".png"};
  for (const std::string form : {"S", "S_mask", "S.mask", "mask_S"}) {
    for (const char* extension : kPictures) {
      std::string mask = form;
      mask.replace(mask.find('S'), 1, stem);
      names.push_back(folder / (mask + extension));
    }
  }
  std::vector<std::string> keys;
  keys.reserve(names.size());
  for (const fs::path& mask : names) keys.push_back(SpellingKey(mask.generic_string()));
  return keys;
}

}  // namespace

MaskFiles::MaskFiles(const fs::path& folder, const std::vector<PosedImage>& images)
    : folder_(folder), of_image_(images.size()) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    throw InputError(folder, fs::exists(folder, error) ? "is not a folder" : "folder is missing");
  }
  const std::set<std::string> pictures(std::begin(kPictures), std::end(kPictures));
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end;
       it.increment(error)) {
    if (!it->is_regular_file(error)) continue;
    if (pictures.count(SpellingKey(it->path().extension().string())) == 0) continue;
    files_.emplace(SpellingKey(it->path().lexically_relative(folder).generic_string()), it->path());
  }
  std::map<std::string, int> of_stem;  // how many photographs have it
  for (const PosedImage& image : images) ++of_stem[fs::path(image.name).stem().string()];
  for (size_t i = 0; i < images.size(); ++i) {
    const fs::path name = images[i].name;
    std::vector<std::string> keys = MaskNames(name);
    if (name.has_parent_path() && of_stem[name.stem().string()] == 1) {
      const std::vector<std::string> flat = MaskNames(name.filename());
      keys.insert(keys.end(), flat.begin(), flat.end());
    }
    for (const std::string& key : keys) {
      const auto found = files_.find(key);
      if (found == files_.end() || IsSameFile(found->second, images[i].image_path)) continue;
      of_image_[i] = found->second;
      break;
    }
  }
}

std::string MaskFiles::Note(const std::vector<PosedImage>& images) const {
  std::set<fs::path> left;
  for (const auto& [key, path] : files_) left.insert(path);
  size_t found = 0;
  std::string missing;
  for (size_t i = 0; i < images.size(); ++i) {
    if (of_image_[i].empty()) {
      if (missing.empty()) missing = images[i].name;
      continue;
    }
    ++found;
    left.erase(of_image_[i]);
  }
  if (found == 0) {
    throw InputError(folder_, "no image has a mask; that of " + missing + " would be called " +
                                  missing + ".png");
  }
  for (const PosedImage& image : images) left.erase(image.image_path);
  if (missing.empty() && left.empty()) return {};
  std::string note = std::to_string(found) + " of " + std::to_string(images.size()) + " views " +
                     (found == 1 ? "has a mask" : "have a mask");
  if (!missing.empty()) {
    note += "; that of " + missing + " would be called " + missing + ".png";
  }
  if (!left.empty()) {
    note += "; " + std::to_string(left.size()) + " files of " + folder_.string() +
            " fit no view, the first is " +
            left.begin()->lexically_relative(folder_).generic_string();
  }
  return note;
}

void NoteMasks(Scene* scene) {
  size_t masked = 0;
  size_t transparent = 0;
  double used = 0;
  for (const View& view : scene->views) {
    transparent += !view.mask_path.empty() && view.mask_path == view.image_path ? 1 : 0;
    if (view.mask.empty()) {
      used += 1;
      continue;
    }
    ++masked;
    used += cv::countNonZero(view.mask) / static_cast<double>(view.mask.total());
  }
  if (transparent > 0) {
    scene->notes.push_back(std::to_string(transparent) +
                           " photographs have transparent pixels, which are not used");
  }
  if (masked > 0) {
    scene->notes.push_back(std::to_string(masked) + " of " + std::to_string(scene->views.size()) +
                           " views have a mask; " +
                           Fixed(100 * used / static_cast<double>(scene->views.size()), 1) +
                           " % of all pixels are used");
  }
}

}  // namespace burin
