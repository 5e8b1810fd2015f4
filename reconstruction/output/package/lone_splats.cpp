// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/lone_splats.h"

#include <algorithm>

#include "reconstruction/output/package/avatar_drawer.h"
#include "reconstruction/subject/surface/lone_parts.h"
#include "sdk/core/task.h"

namespace dpl {
namespace {

constexpr int kMostRounds = 3;
constexpr double kLoneShare = 0.5;

/** Marks in `lone` the splats that draw lone parts of one frame. */
Status markLone(AvatarDrawer& drawer, const TrainFrame& frame, std::vector<uint8_t>& lone) {
    DPL_TRY(const auto picture, frame.picture.get());
    const Cameraf camera = frame.camera.cast<float>();
    SplatEngine& engine = drawer.project(frame.pose, camera);
    SplatImage image;
    engine.blend(image);
    std::vector<uint8_t> drawn, person;
    for (const float alpha : image.alpha) drawn.push_back(255 * alpha >= float(kShownAlpha));
    for (const uint8_t mask : picture->mask.pixels) person.push_back(isPerson(mask));
    const std::vector<uint8_t> parts = loneParts(drawn, person, camera.widthPx, camera.heightPx);
    if (std::find(parts.begin(), parts.end(), uint8_t(1)) == parts.end()) return {};
    std::vector<double> shown(lone.size(), 0), alone(lone.size(), 0);
    addContributions(engine, camera, shown);
    addContributions(engine, camera, alone, parts);
    for (size_t i = 0; i < lone.size(); ++i) lone[i] |= alone[i] > kLoneShare * shown[i];
    return {};
}

/** The splats that are not marked, in their order. */
SplatData without(const SplatData& from, std::span<const uint8_t> marked) {
    SplatData kept;
    kept.shDegree = from.shDegree;
    const size_t sh = from.count() > 0 ? from.sh.size() / from.count() : 0;
    kept.triangleStart.push_back(0);
    for (size_t t = 0; t + 1 < from.triangleStart.size(); ++t) {
        for (uint32_t i = from.triangleStart[t]; i < from.triangleStart[t + 1]; ++i) {
            if (marked[i]) continue;
            kept.uv.push_back(from.uv[i]), kept.phi.push_back(from.phi[i]), kept.scaleM.push_back(from.scaleM[i]);
            kept.opacity.push_back(from.opacity[i]), kept.flags.push_back(from.flags[i]);
            kept.sh.insert(kept.sh.end(), from.sh.begin() + ptrdiff_t(i * sh), from.sh.begin() + ptrdiff_t((i + 1) * sh));
        }
        kept.triangleStart.push_back(kept.count());
    }
    return kept;
}

}  // namespace

Result<uint32_t> dropLoneSplats(AvatarData& avatar, std::span<const TrainFrame> frames, Jobs& jobs) {
    const uint32_t before = avatar.splats.count();
    for (int round = 0; round < kMostRounds; ++round) {
        std::vector<uint8_t> lone(avatar.splats.count(), 0);
        AvatarDrawer drawer(avatar, jobs);
        for (size_t f = 0; f < frames.size(); ++f) {
            if (frames[f].kind == FrameKind::Dynamic) continue;
            DPL_RETURN_IF_ERROR(taskAt(double(f) / double(frames.size()), "lone splats"));
            DPL_RETURN_IF_ERROR(markLone(drawer, frames[f], lone));
        }
        if (std::find(lone.begin(), lone.end(), uint8_t(1)) == lone.end()) break;
        avatar.splats = without(avatar.splats, lone);
    }
    return before - avatar.splats.count();
}

}  // namespace dpl
