// What of a photograph is not to be used: its alpha, and masks by theirs.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>

namespace burin {

// The alpha of a PNG, TIFF or WebP file, CV_8UC1; empty where the file has none, or is opaque everywhere. Throws
// InputError as ReadGrayImage does.
cv::Mat ReadAlpha(const std::filesystem::path& path);

// A mask, CV_8UC1 or CV_32FC1: the file's alpha where it has one (programs that cut out backgrounds save masks so), else
// its grey levels.
cv::Mat ReadMask(const std::filesystem::path& path);

// Where a mask lets pixels be used, CV_8UC1, 0 or 255: where it is not zero; by alpha, where that is opaque.
cv::Mat ReadUsedPixels(const std::filesystem::path& path);

}  // namespace burin
