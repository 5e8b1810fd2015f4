// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/observe/closeup_masks.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/input/capture/frame_picture.h"
#include "reconstruction/input/capture/silhouettes.h"
#include "reconstruction/input/observe/priors.h"
#include "reconstruction/input/observe/refine_matte.h"

namespace dpl {
namespace {

constexpr size_t kFewestViews = 8;  // below it a hull is far wider than the person
constexpr double kSureShare = 0.96, kPossibleShare = 0.8;
constexpr double kVoxels = 4e6;  // of the box about the person: about 8 mm a side

/** The hull of the still training frames, at the share of views that decides, and at shares that take less and more. */
struct Hulls {
    HullVoxels likely, sure, possible;  // empty when there is none
};

Result<Hulls> hullsOf(const Scan& scan, Jobs& jobs) {
    std::vector<SilhouetteView> views;
    for (const ScanFrame& frame : scan.frames) {
        if (frame.kind != FrameKind::StaticFull || frame.split != Split::Train || frame.maskPath.empty()) continue;
        DPL_TRY(ImageGrey8 mask, readFrameMask(frame));
        if (std::any_of(mask.pixels.begin(), mask.pixels.end(), isPerson)) views.push_back({frame.camera, std::move(mask)});
    }
    if (views.size() < kFewestViews) return Hulls{};
    const auto coarse = boundSilhouettes(views, 0, kHullShare, jobs);
    if (!coarse) return Hulls{};
    const double voxelM = coarse->voxelM * std::cbrt(double(coarse->count()) / kVoxels);
    const auto grid = boundSilhouettes(views, voxelM, kHullShare, jobs);
    if (!grid) return Hulls{};
    const SilhouetteVotes votes = voteSilhouettes(views, *grid, jobs);
    const auto at = [&](double share) { return hullVoxels(votes, *grid, share, views.size()); };
    return Hulls{at(kHullShare), at(kSureShare), at(kPossibleShare)};
}

}  // namespace

Result<std::vector<CloseupMask>> checkCloseupMasks(const Scan& scan, const std::function<bool(const ScanFrame&)>& isFound, Jobs& jobs) {
    std::vector<CloseupMask> closeups;
    for (size_t f = 0; f < scan.frames.size(); ++f)
        if (scan.frames[f].kind == FrameKind::StaticCloseup && isFound(scan.frames[f])) closeups.push_back({f, 0, {}});
    if (closeups.empty()) return closeups;
    DPL_TRY(const Hulls hulls, hullsOf(scan, jobs));
    const HullVoxels& hull = hulls.likely;
    if (hull.centres.empty()) return std::vector<CloseupMask>{};
    std::vector<Status> results(closeups.size());
    jobs.forBlocks(closeups.size(), [&](size_t i, uint32_t) {
        CloseupMask& closeup = closeups[i];
        const ScanFrame& frame = scan.frames[closeup.frame];
        results[i] = [&]() -> Status {
            const ImageGrey8 drawn = drawHull(hull, frame.camera);
            if (!frame.maskPath.empty()) {
                DPL_TRY(const ImageGrey8 mask, readFrameMask(frame));
                closeup.agreement = maskIou(drawn, mask);
            }
            closeup.certainty = maskIou(drawHull(hulls.sure, frame.camera), drawHull(hulls.possible, frame.camera));
            // Where the hull says little, a mask has to agree with it as if it said more: nothing else speaks for the mask.
            closeup.contradicted = closeup.agreement < std::max(closeup.certainty, priors::kHullCertainty) - priors::kCloseupSlack;
            if (!closeup.contradicted || closeup.certainty < priors::kHullCertainty) return {};
            DPL_TRY(const ImageRgb8 image, readFrameImage(frame));
            const double nearest = hull.nearestDepthM(frame.camera);
            const int bandPx = std::clamp(int(std::lround(1.5 * hull.voxelM * frame.camera.fx / nearest)), 2, 32);
            closeup.mask = toStoredPixels(refineMatte(image, drawn, bandPx), frame);
            return {};
        }();
    });
    for (const Status& result : results) DPL_RETURN_IF_ERROR(result);
    return closeups;
}

}  // namespace dpl
