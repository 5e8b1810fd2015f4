// SPDX-License-Identifier: Apache-2.0
#include "apps/bench/contestants.h"

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "apps/bench/count_allocations.h"
#include "apps/shared/pictures.h"
#include "reconstruction/base/sdk_camera.h"
#include "reconstruction/output/package/avatar_bytes.h"

namespace dpl {
namespace {

constexpr uint32_t kWarmUp = 2;          // rounds that are not timed
constexpr uint32_t kFramesInFlight = 3;  // every renderer can start this many frames without waiting

Status ours(const doppel::Status& status) {
    return status ? Status() : Status(fromSdk(status.error()));
}

/** A renderer behind the public API. */
class SdkDrawer final : public Drawer {
public:
    SdkDrawer(doppel::Context context, doppel::Avatar avatar, std::span<const Cameraf> views)
        : context_(std::move(context)), avatar_(std::move(avatar)) {
        for (const Cameraf& view : views) {
            cameras_.push_back(sdkCamera(view));
            pictures.emplace_back(size_t(view.widthPx) * view.heightPx * 4);
        }
        for (std::vector<uint8_t>& picture : pictures) {
            DplImage image{};
            image.structSize = sizeof image;
            image.rgba = picture.data();
            image.rgbaBytes = picture.size();
            images_.push_back(image);
        }
    }
    Status pose(std::span<const float> rotations, const Vec3f& root) override {
        return rotations.empty() ? Status() : ours(avatar_.setPose(rotations, {&root.x, 3}));
    }
    Status draw() override { return ours(avatar_.draw(cameras_)); }
    Status read() override { return ours(avatar_.readImages(images_)); }
    Result<DrawerStats> stats() override {
        auto frame = avatar_.frameStats();
        if (!frame) return fromSdk(frame.error());
        DrawerStats stats{*frame, {}};
        for (uint32_t p = 0; p < frame->passCount; ++p) {
            auto time = avatar_.passTime(p);
            if (!time) return fromSdk(time.error());
            stats.passes.emplace_back(time->label, time->milliseconds);
        }
        return stats;
    }

private:
    doppel::Context context_;
    doppel::Avatar avatar_;
    std::vector<DplCamera> cameras_;
    std::vector<DplImage> images_;
};

/** GPU times of the frame that was drawn last. */
Status samplePasses(Contestant& c) {
    DPL_TRY(const DrawerStats stats, c.drawer->stats());
    c.stats = stats.frame;
    c.gpuMilliseconds.push_back(stats.frame.gpuMs);
    for (PassSamples& pass : c.passes) pass.milliseconds.push_back(0);
    for (const auto& [label, milliseconds] : stats.passes) {
        auto pass = std::find_if(c.passes.begin(), c.passes.end(), [&](const PassSamples& known) { return known.label == label; });
        if (pass == c.passes.end()) pass = c.passes.insert(pass, {label, std::vector<double>(c.gpuMilliseconds.size())});
        pass->milliseconds.back() += milliseconds;
    }
    return {};
}

Status inWords(const Contestant& c, const Status& status) {
    return status ? Status() : Status(fail(status.error().code, "{}: {}", c.name, status.error().message));
}

struct FrameCost {
    double milliseconds = 0, drawMilliseconds = 0;
    uint64_t allocations = 0;
};

CountedThreads countedThreads(const Contestant& c) {
    return c.option == "software" ? CountedThreads::All : CountedThreads::Own;
}

/** Poses, draws and reads one frame; the time is from the draw on. */
Result<FrameCost> drawFrame(Contestant& c, const BenchSubject& subject) {
    AllocationCount count(countedThreads(c));
    const Status posed = c.drawer->pose(subject.rotations, subject.root);
    const auto start = std::chrono::steady_clock::now();
    const Status drawn = posed ? c.drawer->draw() : posed;
    const double drawMilliseconds = millisecondsSince(start);
    const uint64_t allocations = count.stop();
    DPL_RETURN_IF_ERROR(inWords(c, drawn));
    DPL_RETURN_IF_ERROR(inWords(c, c.drawer->read()));
    return FrameCost{millisecondsSince(start), drawMilliseconds, allocations};
}

struct ViewError {
    PictureError error;
    double flip = 0;
};

/** Starts as many frames as may be in flight before it reads the last one. */
Result<uint64_t> drawInFlight(Contestant& c, const BenchSubject& subject) {
    AllocationCount count(countedThreads(c));
    Status drawn;
    for (uint32_t frame = 0; frame < kFramesInFlight && drawn; ++frame) {
        drawn = c.drawer->pose(subject.rotations, subject.root);
        if (drawn) drawn = c.drawer->draw();
    }
    const uint64_t allocations = count.stop();
    DPL_RETURN_IF_ERROR(inWords(c, drawn));
    DPL_RETURN_IF_ERROR(inWords(c, c.drawer->read()));
    return allocations;
}

}  // namespace

double millisecondsSince(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

Result<BenchSubject> BenchSubject::load(const BenchOptions& options) {
    DPL_TRY(std::vector<uint8_t> bytes, readAvatarBytes(options.avatar));
    auto context = doppel::Context::create(DPL_RENDERER_SOFTWARE, options.threadCount);
    if (!context) return fromSdk(context.error());
    auto avatar = context->loadAvatar(bytes);
    if (!avatar) return fail(fromSdk(avatar.error()).code, "{}: {}", options.avatar.string(), avatar.error().message);
    if (!options.clip.empty()) {
        DPL_TRY(const uint32_t clip, chooseClip(*avatar, options.clip, options.animation));
        if (auto set = avatar->setPoseFromClip(clip, options.timeS, true); !set) return fromSdk(set.error());
    }
    auto info = avatar->info();
    if (!info) return fromSdk(info.error());
    BenchSubject subject{
        std::move(bytes), std::move(*context), std::move(*avatar), *info, std::vector<float>(size_t(info->jointCount) * 4), Vec3f(0),
        Mat3d(1)};
    auto axes = subject.avatar.fileAxes();
    if (!axes) return fromSdk(axes.error());
    subject.turnOnLoading = loadedFromFile(*axes);
    if (info->jointCount > 0 && dplGetPose(subject.avatar.handle(), subject.rotations.data(), info->jointCount, &subject.root.x) != DPL_OK)
        return fail(Code::Internal, "{}", dplGetLastError());
    return subject;
}

std::vector<Cameraf> BenchSubject::views(const BenchCase& test, const std::string& axes) const {
    constexpr float kZoom = 4;
    constexpr float kHeadAbove = 0.36f;  // height of the head above the centre, as a share of the unzoomed picture's height
    Cameraf centre = frameAvatar(info, test.widthPx, test.heightPx, 0.4, uprightFromLoaded(axes, turnOnLoading));
    if (test.portrait) centre.fx *= kZoom, centre.fy *= kZoom, centre.cy += kZoom * kHeadAbove * float(test.heightPx);
    if (test.viewCount == 1) return {centre};
    return {shiftedSideways(centre, -kEyeDistanceM / 2), shiftedSideways(centre, kEyeDistanceM / 2)};
}

Result<Contestant> sdkContestant(const std::string& renderer, const BenchOptions& options, const BenchSubject& subject,
                                 std::span<const Cameraf> views) {
    const DplFill fill = renderer == "vulkan-quads" ? DPL_FILL_QUADS : renderer == "vulkan-tiles" ? DPL_FILL_TILES : fillOf(options.fill);
    auto context =
        doppel::Context::create(renderer == "software" ? DPL_RENDERER_SOFTWARE : DPL_RENDERER_VULKAN, options.threadCount, 0, fill);
    if (!context) return Error{Code::Unsupported, context.error().message};
    const auto start = std::chrono::steady_clock::now();
    auto avatar = context->loadAvatar(subject.bytes);
    const double loadMilliseconds = millisecondsSince(start);
    if (!avatar) return fromSdk(avatar.error());
    const std::string name = context->rendererName();
    return Contestant{name, renderer, false, std::make_unique<SdkDrawer>(std::move(*context), std::move(*avatar), views), loadMilliseconds};
}

Result<std::vector<Contestant>> contestants(const ContestantMaker& make, const BenchOptions& options, const BenchSubject& subject,
                                            std::span<const Cameraf> views) {
    std::vector<Contestant> list;
    Error why{Code::Unsupported, "no renderer could be started"};
    for (const std::string& renderer : options.renderers) {
        auto contestant = make(renderer, options, subject, views);
        if (contestant) {
            list.push_back(std::move(*contestant));
            continue;
        }
        why = contestant.error();
        if (why.code != Code::Unsupported) return fail(why.code, "{}: {}", options.avatar.string(), why.message);
        std::fprintf(stderr, "bench: %s is left out: %s\n", renderer.c_str(), why.message.c_str());
    }
    if (list.empty()) return why;
    return list;
}

Status timeFrames(std::vector<Contestant>& list, const BenchSubject& subject, uint32_t repeats,
                  const std::function<Status(double)>& progress) {
    const uint32_t rounds = repeats + kWarmUp;
    uint64_t coldAllocations = 0;
    std::vector<uint64_t> waitsBefore(list.size(), 0);
    for (uint32_t round = 0; round < rounds; ++round)
        for (size_t i = 0; i < list.size(); ++i) {
            Contestant& c = list[i];
            DPL_TRY(const FrameCost cost, drawFrame(c, subject));
            if (round < kWarmUp) {
                coldAllocations += cost.allocations;
                DPL_TRY(const DrawerStats stats, c.drawer->stats());
                waitsBefore[i] = stats.frame.waits;
            } else {
                c.milliseconds.push_back(cost.milliseconds);
                c.drawMilliseconds.push_back(cost.drawMilliseconds);
                c.warmAllocations += cost.allocations;
                DPL_RETURN_IF_ERROR(samplePasses(c));
            }
            DPL_RETURN_IF_ERROR(progress((round + 1.0) / rounds));
        }
    if (coldAllocations == 0) return fail(Code::Internal, "the first frames allocated nothing: the counter of allocations does not count");
    for (size_t i = 0; i < list.size(); ++i) {
        Contestant& c = list[i];
        DPL_TRY(const uint64_t allocations, drawInFlight(c, subject));
        c.warmAllocations += allocations;
        DPL_TRY(const DrawerStats stats, c.drawer->stats());
        c.warmWaits = stats.frame.waits - waitsBefore[i];
    }
    return {};
}

Status measureErrors(std::vector<Contestant>& list, const BenchSubject& subject, std::span<const Cameraf> views,
                     const ReferenceFile& referee, const std::function<Status(double)>& progress) {
    for (size_t v = 0; v < views.size(); ++v) {
        const ReferencePicture want = referee.draw(subject.rotations, subject.root, views[v]);
        std::vector<ViewError> errors;
        for (size_t i = 0; i < list.size(); ++i) {
            const std::vector<uint8_t>& picture = list[i].drawer->pictures[v];
            // FLIP is slower than most frames, so contestants with identical pictures share one result.
            const auto same = std::find_if(list.begin(), list.begin() + std::ptrdiff_t(i),
                                           [&](const Contestant& earlier) { return earlier.drawer->pictures[v] == picture; });
            if (same != list.begin() + std::ptrdiff_t(i))
                errors.push_back(ViewError(errors[size_t(same - list.begin())]));
            else
                errors.push_back({compareWith(want, picture), coveredFlip(want, picture)});
            list[i].error += errors[i].error, list[i].flip += errors[i].flip / double(views.size());
            DPL_RETURN_IF_ERROR(progress((double(v) + double(i + 1) / double(list.size())) / double(views.size())));
        }
    }
    return {};
}

Status checkWarmFrames(const std::vector<Contestant>& list, const BenchCase& test) {
    for (const Contestant& c : list)
        if (!c.frozen && (c.warmAllocations > 0 || c.warmWaits > 0))
            return fail(Code::Internal, "{}, {}: warm frames allocated {} times and waited {} times; both must be 0", test.name, c.name,
                        c.warmAllocations, c.warmWaits);
    return {};
}

}  // namespace dpl
