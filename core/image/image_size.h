// How large a photograph is, from its header: decoding it would take a hundred times as long.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>

namespace burin {

// Width and height as stored (an orientation tag is ignored). Of formats other than PNG and JPEG the picture is decoded.
// Throws InputError when the file is missing or no picture.
cv::Size ImageSize(const std::filesystem::path& path);

}  // namespace burin
