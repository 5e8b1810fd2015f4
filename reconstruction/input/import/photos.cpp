// SPDX-License-Identifier: Apache-2.0
// A folder of photos without cameras. The order of the file names is taken for the order in which they were made, as phones name them.
#include <algorithm>

#include "reconstruction/base/image_file.h"
#include "reconstruction/input/capture/scan_readers.h"
#include "reconstruction/input/import/exif.h"
#include "reconstruction/input/import/folder_contents.h"
#include "reconstruction/input/import/readers.h"

namespace dpl {

namespace fs = std::filesystem;

Result<Capture> readPhotos(const fs::path& folder, uint32_t longSidePx) {
    Capture capture;
    capture.longSidePx = longSidePx;
    capture.what = "folder of photos";
    std::vector<double> focals;
    size_t reduced = 0;
    LeftOut left;
    const std::vector<fs::path> images = picturesIn(folder);
    for (const fs::path& image : images) {
        if (capture.pictures.size() >= kMaxFrames)
            return fail(Code::Unsupported, "{}: more than {} pictures; remove some", folder.string(), kMaxFrames);
        const auto bytes = readCompleteImage(image);
        if (!bytes) {
            left.add(image.filename(), bytes.error());
            continue;
        }
        CapturePicture picture;
        const std::string stem = image.stem().string();
        if (stem.starts_with("close")) picture.kind = FrameKind::StaticCloseup;
        if (stem.starts_with("dyn")) picture.kind = FrameKind::Dynamic;
        picture.name = frameName(picture.kind, capture.pictures.size());
        picture.image = image;
        DPL_TRY(const ImageHeader header, probeImage(image));
        const double shrink = std::min(1.0, double(longSidePx) / std::max(header.widthPx, header.heightPx));
        reduced += shrink < 1;
        if (const ExifFields exif = readExif(*bytes); exif.focalLength35Mm > 0)
            focals.push_back(shrink * focalFrom35Mm(exif.focalLength35Mm, header.widthPx, header.heightPx));
        capture.pictures.push_back(std::move(picture));
    }
    DPL_RETURN_IF_ERROR(left.check(capture.pictures.size()));
    if (!left.empty()) capture.notes.push_back(left.sentence(images.size()));
    if (reduced > 0)
        capture.notes.push_back(formatText("{} photos are reduced to {} pixels on their longer side (--long-side)", reduced, longSidePx));
    if (focals.empty()) {
        capture.notes.push_back("no photo states a focal length (EXIF); it is estimated with the cameras");
        return capture;
    }
    std::sort(focals.begin(), focals.end());
    capture.focalGuessPx = focals[focals.size() / 2];
    if (focals.back() > 1.05 * focals.front())
        capture.notes.push_back(formatText(
            "the photos were made with different zooms (focal lengths from {} to {} px); one lens without zoom gives better cameras",
            int(focals.front()), int(focals.back())));
    return capture;
}

}  // namespace dpl
