// Puts pictures side by side, labels them, and writes them to files.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace burin {

// The pictures (8-bit, grey or colour) in a row on white, each under its caption (ASCII; may be
// empty). Pictures taller than the lowest one are scaled down to it. CHECKs that there is a picture
// and as many captions as pictures.
cv::Mat3b SideBySide(const std::vector<cv::Mat>& pictures,
                     const std::vector<std::string>& captions);

// Draws one line of ASCII text, at most `size.width` wide and about `size.height` high, shrunk to
// fit, its left end and vertical middle at `left_middle`.
void DrawText(const std::string& text, const cv::Point& left_middle, const cv::Size& size,
              cv::Mat3b* picture);

// Writes by the extension (.png, .jpg), atomically. Throws InputError when it cannot.
void WritePicture(const std::filesystem::path& path, const cv::Mat& picture);

}  // namespace burin
