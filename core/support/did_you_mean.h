// Suggestions for misspelt names of options, commands and scenes.
#pragma once

#include <string>
#include <vector>

namespace burin {

// " (did you mean X?)" with the candidate nearest to `name` in edit distance, the first of equals;
// empty when every candidate differs in more than a quarter of the letters (two for short names).
std::string DidYouMean(const std::string& name, const std::vector<std::string>& candidates);

}  // namespace burin
