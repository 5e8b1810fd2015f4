// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/frames/frame_contestants.h"

#include <algorithm>

#include "sdk/api/frame_stats.h"
#include "sdk/backend/vulkan/vulkan_test_options.h"
#include "sdk/format/avatar_file.h"
#include "sdk/format/splat_file.h"
#include "sdk/render/gpu_renderer.h"
#include "tools/bench/baseline/plain_file.h"

namespace dpl {
namespace {

struct Switch {
    const char* renderer;  // value of --renderers
    const char* label;     // printed after the renderer's name
    GpuOptions options;
};
constexpr Switch kSwitches[] = {
    {"vulkan-without-culling", "no culling", {.cull = false}},
    {"vulkan-float-keys", "32-bit keys", {.quantiseDepth = false}},
    {"vulkan-two-frames", "a frame an eye", {.shareViews = false}},
    {"vulkan-tiles-all-off", "all switches off", {.cull = false, .shareViews = false, .quantiseDepth = false, .fill = Fill::Tiles}}};
constexpr const char *kPlainFloat = "vulkan-plain-float", *kPlainTiles = "vulkan-plain-tiles";

void setPose(Pose& pose, std::span<const float> rotations, const Vec3f& root) {
    pose.localRotations.resize(rotations.size() / 4);
    for (size_t j = 0; j < pose.localRotations.size(); ++j)
        pose.localRotations[j] = Quatf(rotations[4 * j + 3], rotations[4 * j], rotations[4 * j + 1], rotations[4 * j + 2]);
    pose.rootTranslation = root;
}

/** Today's GPU renderer without the public API in front of it. */
class SwitchedDrawer final : public Drawer {
public:
    SwitchedDrawer(std::unique_ptr<Renderer> renderer, RenderAvatarId avatar, std::span<const Cameraf> views)
        : renderer_(std::move(renderer)), avatar_(avatar), views_(views.begin(), views.end()) {
        for (const Cameraf& view : views) pictures.emplace_back(size_t(view.widthPx) * view.heightPx * 4);
    }
    Status pose(std::span<const float> rotations, const Vec3f& root) override { return setPose(pose_, rotations, root), Status(); }
    Status draw() override { return renderer_->draw(avatar_, pose_, views_, {}); }
    Status read() override {
        DPL_TRY(const std::span<const PixelView> pixels, renderer_->read(avatar_));
        for (size_t v = 0; v < pictures.size(); ++v) std::copy(pixels[v].rgba.begin(), pixels[v].rgba.end(), pictures[v].begin());
        return {};
    }
    Result<DrawerStats> stats() override {
        DPL_TRY(const FrameStats s, renderer_->stats(avatar_));
        DrawerStats out{};
        out.frame = api::publicStats(s);
        for (const PassTime& pass : s.passes) out.passes.emplace_back(pass.label, pass.milliseconds);
        return out;
    }

private:
    std::unique_ptr<Renderer> renderer_;
    RenderAvatarId avatar_;
    std::vector<Cameraf> views_;
    Pose pose_;
};

/** The frozen baseline, with either fill. */
class PlainDrawer final : public Drawer {
public:
    PlainDrawer(PlainFile file, std::span<const Cameraf> views) : file_(std::move(file)), views_(views.begin(), views.end()) {
        pictures.resize(views.size());
    }
    Status pose(std::span<const float> rotations, const Vec3f& root) override {
        rotations_.assign(rotations.begin(), rotations.end()), root_ = root;
        return {};
    }
    Status draw() override { return file_.draw(rotations_, root_, views_); }
    Status read() override { return file_.read(pictures); }
    Result<DrawerStats> stats() override {
        const PlainStats plain = file_.stats();
        DrawerStats stats{};
        stats.frame.viewCount = uint32_t(views_.size()), stats.frame.splatsDrawn = plain.splatsDrawn;
        stats.frame.residentBytes = plain.residentBytes, stats.frame.avatarBytes = plain.avatarBytes,
        stats.frame.splatBytes = plain.splatBytes;
        for (const PlainPassTime& pass : plain.passes)
            stats.passes.emplace_back(pass.label, pass.milliseconds), stats.frame.gpuMs += pass.milliseconds;
        return stats;
    }

private:
    PlainFile file_;
    std::vector<Cameraf> views_;
    std::vector<float> rotations_;
    Vec3f root_{0};
};

Result<Contestant> plainContestant(const std::string& renderer, const BenchSubject& subject, std::span<const Cameraf> views) {
    const auto start = std::chrono::steady_clock::now();
    DPL_TRY(PlainFile file, PlainFile::open(subject.bytes, renderer == kPlainTiles ? PlainFill::Tiles : PlainFill::Quads));
    const double loadMilliseconds = millisecondsSince(start);
    const std::string name = file.name();
    auto drawer = std::make_unique<PlainDrawer>(std::move(file), views);
    if (renderer == kPlainTiles) {  // its lists have a fixed size; draw one frame to see whether they hold this subject
        DPL_RETURN_IF_ERROR(drawer->pose(subject.rotations, subject.root));
        DPL_RETURN_IF_ERROR(drawer->draw());
        DPL_RETURN_IF_ERROR(drawer->read());
    }
    return Contestant{name, renderer, "", true, std::move(drawer), loadMilliseconds};
}

Result<Contestant> switchedContestant(const Switch& off, const BenchSubject& subject, std::span<const Cameraf> views) {
    VulkanTestOptions vulkan;
    vulkan.allowSoftwareDevice = true;
    auto backend = createVulkanBackend(vulkan);
    if (!backend) return fail(Code::Unsupported, "no Vulkan on this machine: {}", backend.error().message);
    const std::string device = "vulkan: " + (*backend)->info().name;
    GpuOptions options = off.options;
    options.preciseBlending = vulkan.preciseBlending;
    auto renderer = std::make_unique<GpuRenderer>(std::move(*backend), device, options);
    const std::string whole = renderer->name();
    const auto start = std::chrono::steady_clock::now();
    RenderAvatarId id = 0;
    if (splatFormatOf(subject.bytes) != SplatFormat::None) {
        DPL_TRY(const SplatFile general, readSplats(subject.bytes));
        DPL_TRY(id, renderer->addSplats(general.splats));
    } else {
        DPL_TRY(CodedAvatar coded, readCodedAvatar(subject.bytes));
        coded.avatar.mesh.colours = {};
        const auto data = std::make_shared<const AvatarData>(std::move(coded.avatar));
        DPL_TRY(id, renderer->addCodedAvatar(data, std::move(coded.splats)));
    }
    const double loadMilliseconds = millisecondsSince(start);
    return Contestant{
        whole + ", " + off.label, off.renderer, whole, false, std::make_unique<SwitchedDrawer>(std::move(renderer), id, views),
        loadMilliseconds};
}

}  // namespace

const std::vector<std::string>& frameRenderers() {
    static const std::vector<std::string> kNames = [] {
        std::vector<std::string> names = {"software", "vulkan-quads", "vulkan-tiles", kPlainFloat, kPlainTiles};
        for (const Switch& s : kSwitches) names.push_back(s.renderer);
        return names;
    }();
    return kNames;
}

Result<Contestant> frameContestant(const std::string& renderer, const BenchOptions& options, const BenchSubject& subject,
                                   std::span<const Cameraf> views) {
    if (renderer == kPlainFloat || renderer == kPlainTiles) return plainContestant(renderer, subject, views);
    const auto off = std::find_if(std::begin(kSwitches), std::end(kSwitches), [&](const Switch& s) { return renderer == s.renderer; });
    if (off == std::end(kSwitches)) return sdkContestant(renderer, options, subject, views);
    if (!off->options.shareViews && off->options.cull && views.size() == 1)
        return fail(Code::Unsupported, "one view is one frame either way");
    return switchedContestant(*off, subject, views);
}

}  // namespace dpl
