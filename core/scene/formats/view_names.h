// Names of views. Files name photographs by the path that they had where the file was written. A view's
// name is a path below the folder of the photographs. Masks are found by it, and results are written
// under it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/scene/formats/posed_images.h"

namespace burin {

// Makes the names paths inside a folder: "." and ".." are resolved, '\' is '/'. Where a name is absolute
// or leaves its folder, all lose the folders that they have in common. Throws InputError for a name that
// is empty or has control characters.
void SettleNames(PosedScene* posed);

// What SettleNames does, for names alone; folders in common go also when `without_common`. `file` is for
// errors.
std::vector<std::string> SettledNames(const std::vector<std::string>& names,
                                      const std::filesystem::path& file,
                                      bool without_common = false);

// The photograph `name` in `folder`, with as many of the name's own folders as there are. Throws
// InputError when it is in none of them.
std::filesystem::path FindPhotographBelow(const std::string& name,
                                          const std::filesystem::path& folder);

// The name with the extension of a PNG, JPEG or TIFF that the format leaves out, where one of `places` is a file with it.
std::string WithExtension(const std::string& name,
                          const std::vector<std::filesystem::path>& places);

}  // namespace burin
