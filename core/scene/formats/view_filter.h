// Which views of a scene are read: `views` and `skip` as the user gives them.
#pragma once

#include <string>

#include "core/scene/formats/posed_images.h"

namespace burin {

// Patterns separated by commas; * stands for any characters, ? for one. A pattern means the views whose name, or whose
// name's last part, it fits.
struct ViewFilter {
  std::string views;  // those to be read; empty = all
  std::string skip;   // those of them that are left out
};

// Takes out the views that the filter leaves out, with their share of points and tracks, and notes how many. Throws
// InputError for a pattern that fits no view.
void LeaveOutViews(const ViewFilter& filter, PosedScene* posed);

// Takes out the images i with keep[i] = 0. Points keep their place.
void KeepImages(const std::vector<char>& keep, PosedScene* posed);

}  // namespace burin
