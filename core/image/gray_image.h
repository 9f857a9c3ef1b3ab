// Reads and writes grey images. An image is read whole, or an error says what is wrong with the file:
// OpenCV alone returns a truncated JPEG as an image with a grey lower part.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>

namespace burin {

// Grey levels 0..255 of an image file that OpenCV can decode: CV_8UC1 from 8 bits a channel,
// CV_32FC1 (v * 255 / 65535) from 16. Colour is converted, an orientation tag is ignored (camera
// calibration refers to the pixels as stored). Throws InputError when the file is missing,
// truncated, not an image or of another depth.
cv::Mat ReadGrayImage(const std::filesystem::path& path);

// Writes CV_8UC1 or CV_32FC1 (rounded and clamped to 0..255) as 8-bit PNG or JPEG (quality 95) by
// the extension .png, .jpg or .jpeg, atomically and with the same bytes for the same image. Throws
// InputError for another extension or when the file cannot be written.
void WriteGrayImage(const cv::Mat& gray, const std::filesystem::path& path);

// The extension of a file that WriteGrayImage can write, in lower case; throws its InputError for
// another, so that callers can ask before they write anything.
std::string WritableExtension(const std::filesystem::path& path);

}  // namespace burin
