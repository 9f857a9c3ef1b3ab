#include "apps/run/debug_images.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/image/picture.h"
#include "costs/warp_picture.h"

namespace burin {

void WriteDebugImages(const std::filesystem::path& folder, int level, const RoundContext& context,
                      const PhotometricOptions& options, const std::vector<std::string>& names) {
  for (size_t i = 0; i < context.views->size(); ++i) {
    const ViewDomain& domain = (*context.domains)[i];
    if (domain.seconds.empty()) continue;
    const LevelView& view = (*context.views)[i];
    const cv::Mat1f image = view.FloatImage();
    const WindowMasks masks = MakeWindowMasks(
        MakeDepthPlanes(domain, *context.mesh, view.camera), options.window / 2, options.mask.mode,
        options.mask.plane_px,
        static_cast<int>(std::ceil(options.min_valid_share * options.window * options.window)));
    const WarpPicture pair =
        MakeWarpPicture(*context.views, static_cast<int>(i), domain, 0, *context.mesh);
    cv::Mat grey;
    image.convertTo(grey, CV_8U);
    const LevelView& warped = (*context.views)[domain.seconds[0]];
    cv::Mat without;
    cv::Mat with;
    WindowErrors(view, warped, pair, options, nullptr).convertTo(without, CV_8U, 255);
    WindowErrors(view, warped, pair, options, &masks).convertTo(with, CV_8U, 255);
    const std::string& second = names[domain.seconds[0]];
    // Views in different folders may have files of one name.
    std::string stem = std::filesystem::path(names[i]).replace_extension().string();
    std::replace(stem.begin(), stem.end(), '/', '_');
    WritePicture(folder / ("level" + std::to_string(level) + "_" + stem + ".png"),
                 SideBySide({grey, KeptTapsPicture(image, domain, masks), without, with},
                            {names[i], "valid taps, mask.mode " + NameOf(options.mask.mode),
                             "1 - ZNCC with " + second + ", no masks", "with masks"}));
  }
}

}  // namespace burin
