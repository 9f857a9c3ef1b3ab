// What the mask of a photograph means.
#pragma once

#include "core/support/choices.h"
#include "core/support/options.h"

namespace burin {

// kIgnore: where the mask is zero, the pixel is not used. kObject: also the object is not there, so that the border of
// what is not zero is its outline.
enum class MaskMeaning { kIgnore, kObject };
inline Choices<MaskMeaning> ChoicesOf(MaskMeaning) {
  return {{MaskMeaning::kIgnore, "ignore"}, {MaskMeaning::kObject, "object"}};
}

struct ImageMaskOptions {
  MaskMeaning meaning = MaskMeaning::kIgnore;
  void Describe(OptionSet* set) {
    set->Add(
        "masks.meaning", &meaning,
        "What zero in a mask says: ignore = the pixel is not to be used; object = also that the "
        "object is not there, so that masks have outlines (docs/silhouettes.md)");
  }
};

}  // namespace burin
