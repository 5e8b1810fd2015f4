// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/frames/frame_contestants.h"

#include "tools/bench/baseline/plain_file.h"

namespace dpl {
namespace {

constexpr const char *kPlainFloat = "vulkan-plain-float", *kPlainTiles = "vulkan-plain-tiles";

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
    return Contestant{name, renderer, true, std::move(drawer), loadMilliseconds};
}

}  // namespace

const std::vector<std::string>& frameRenderers() {
    static const std::vector<std::string> kNames = {"software", "vulkan-quads", "vulkan-tiles", kPlainFloat, kPlainTiles};
    return kNames;
}

Result<Contestant> frameContestant(const std::string& renderer, const BenchOptions& options, const BenchSubject& subject,
                                   std::span<const Cameraf> views) {
    if (renderer == kPlainFloat || renderer == kPlainTiles) return plainContestant(renderer, subject, views);
    return sdkContestant(renderer, options, subject, views);
}

}  // namespace dpl
