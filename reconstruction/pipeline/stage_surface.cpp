#include <cstring>

#include "reconstruction/pipeline/subject_data.h"
#include "reconstruction/surface/fit_surface.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

Status fit(const SubjectData& subject, StageContext& context) {
    std::vector<SurfaceView> views;
    for (size_t f = 0; f < subject.scan.frames.size(); ++f) {
        const ScanFrame& frame = subject.scan.frames[f];
        if (frame.split != Split::Train || frame.kind != FrameKind::StaticFull || !subject.usable[f] || frame.maskPath.empty()) continue;
        DPL_TRY(ImageGrey8 mask, readFrameMask(frame));
        views.push_back({frame.camera, std::move(mask), subject.fit.poses[f]});
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
    return writeFileAtomically(context.folder / "offsets.bin",
                               std::span(reinterpret_cast<const uint8_t*>(surface.restOffsets.data()), surface.restOffsets.size() * sizeof(Vec3f)));
}

}  // namespace

Status runSurface(SubjectData& subject) {
    DPL_TRY(std::string training, trainingDataHash(subject));
    const nlohmann::json inputs = {{"training", training}, {"body_fit", subject.chain.keyOf("body-fit")}};
    auto folder = subject.chain.run("surface", 1, inputs, [&](StageContext& context) { return fit(subject, context); });
    if (!folder) return folder.error();
    DPL_TRY(auto bytes, readFile(*folder / "offsets.bin"));
    subject.surfaceOffsets.resize(subject.shaped.mesh.restPositions.size());
    if (bytes.size() != subject.surfaceOffsets.size() * sizeof(Vec3f)) return fail(Code::CorruptData, "{} does not fit the body; delete it and run again", (*folder / "offsets.bin").string());
    std::memcpy(static_cast<void*>(subject.surfaceOffsets.data()), bytes.data(), bytes.size());
    return {};
}

}  // namespace dpl
