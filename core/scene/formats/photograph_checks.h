// Photographs compared with what a scene says of them, once its files have been read.
#pragma once

#include "core/scene/formats/posed_images.h"

namespace burin {

// Photographs that are missing under their name are looked for under its other spellings (core/support/spelling.h).
void FindSpellings(PosedScene* posed);

// Throws InputError where two views have one photograph, naming both.
void CheckOneViewAPhotograph(const PosedScene& posed);

// Throws InputError naming the first photograph that is not there.
void RequirePhotographs(const PosedScene& posed);

// Cameras whose photograph was scaled by one factor since (both sides, to a pixel) are scaled like it, and so is what was
// measured in it. One note says how many. Others are left for reading to refuse.
void ScaleToPhotographs(PosedScene* posed);

}  // namespace burin
