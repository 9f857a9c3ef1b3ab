// Pictures of what a round saw: for each view the taps that its windows keep, and its pairs' errors with
// and without occlusion masks.
#pragma once

#include <filesystem>

#include "core/solve/energy_term.h"
#include "costs/photometric_energy.h"

namespace burin {

// Writes, for every view that is the reference of a pair, folder/levelL_NAME.png: photograph, kept
// taps (red), and 1 - ZNCC of its first pair without and with masks (black 0, white 1 and more), all
// of the frozen state of `context`. `names` are those of the views. Throws InputError when a file
// cannot be written.
void WriteDebugImages(const std::filesystem::path& folder, int level, const RoundContext& context,
                      const PhotometricOptions& options, const std::vector<std::string>& names);

}  // namespace burin
