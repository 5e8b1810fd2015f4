// SPDX-License-Identifier: Apache-2.0
#include <cstring>

#include "reconstruction/pipeline/subject_data.h"
#include "reconstruction/surface/fit_surface.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

/** Still training frames with a mask: the silhouettes that shape the surface. */
std::vector<size_t> silhouetteFrames(const SubjectData& subject) {
    std::vector<size_t> frames;
    for (size_t f = 0; f < subject.scan.frames.size(); ++f) {
        const ScanFrame& frame = subject.scan.frames[f];
        if (frame.split == Split::Train && frame.kind == FrameKind::StaticFull && subject.usable[f] && !frame.maskPath.empty())
            frames.push_back(f);
    }
    return frames;
}

std::span<const uint8_t> bytesOf(const std::vector<Vec3f>& values) {
    return {reinterpret_cast<const uint8_t*>(values.data()), values.size() * sizeof(Vec3f)};
}

Result<std::vector<Vec3f>> readVectors(const std::filesystem::path& path, size_t count) {
    DPL_TRY(auto bytes, readFile(path));
    if (bytes.size() != count * sizeof(Vec3f))
        return fail(Code::CorruptData, "{} does not fit the body and the scan; delete it and run again", path.string());
    std::vector<Vec3f> values(count);
    std::memcpy(static_cast<void*>(values.data()), bytes.data(), bytes.size());
    return values;
}

Status fit(const SubjectData& subject, StageContext& context) {
    std::vector<SurfaceView> views;
    for (size_t f : silhouetteFrames(subject)) {
        DPL_TRY(ImageGrey8 mask, readFrameMask(subject.scan.frames[f]));
        views.push_back({subject.scan.frames[f].camera, std::move(mask), subject.fit.poses[f]});
    }
    if (views.empty()) return fail(Code::InvalidArgument, "no still training frame has a mask; add masks, or let --models find the person");
    SurfaceFitSettings settings;
    settings.progress = [&](double fraction) {
        context.progress.update(fraction, formatText("{} silhouettes", views.size()));
        return !context.progress.cancelled();
    };
    DPL_TRY(SurfaceFit surface, fitSurface(subject.shaped.mesh, subject.shaped.joints, views, settings, subject.jobs));
    const nlohmann::json info = {{"mean_iou_before", surface.meanIouBefore},
                                 {"mean_iou_after", surface.meanIouAfter},
                                 {"mean_offset_m", surface.meanOffsetM},
                                 {"largest_offset_m", surface.largestOffsetM}};
    DPL_CHECK_OK(writeFileAtomically(context.folder / "surface.json", info.dump(1)));
    DPL_CHECK_OK(writeFileAtomically(context.folder / "sway.bin", bytesOf(surface.viewTranslationsM)));
    return writeFileAtomically(context.folder / "offsets.bin", bytesOf(surface.restOffsets));
}

}  // namespace

Status runSurface(SubjectData& subject) {
    DPL_TRY(std::string training, trainingDataHash(subject));
    const nlohmann::json inputs = {{"training", training}, {"body_fit", subject.chain.keyOf("body-fit")}};
    auto folder = subject.chain.run("surface", 1, inputs, [&](StageContext& context) { return fit(subject, context); });
    if (!folder) return folder.error();
    DPL_TRY(subject.surfaceOffsets, readVectors(*folder / "offsets.bin", subject.shaped.mesh.restPositions.size()));
    const std::vector<size_t> frames = silhouetteFrames(subject);
    DPL_TRY(std::vector<Vec3f> sway, readVectors(*folder / "sway.bin", frames.size()));
    for (size_t i = 0; i < frames.size(); ++i) subject.fit.poses[frames[i]].rootTranslation += sway[i];
    return {};
}

}  // namespace dpl
