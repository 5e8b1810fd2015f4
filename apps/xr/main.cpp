// SPDX-License-Identifier: Apache-2.0
// doppel-xr: an avatar in a lit room, or in the real one, on any OpenXR headset.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <thread>

#include "apps/shared/checks.h"
#include "apps/shared/pictures.h"
#include "apps/xr/avatar_scene.h"
#include "apps/xr/captured_files.h"
#include "platform/openxr/session.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr double kExitSeconds = 10;
volatile std::sig_atomic_t interrupted = 0;  // by Ctrl-C
const std::vector<std::string> kBlendNames = {"opaque", "additive", "alpha"};

struct Options {
    std::filesystem::path avatar, capture;
    std::string clip, animation, blend = "opaque";
    uint64_t frames = 0;
    double waitS = 30;
    bool mirror = false, withoutHands = false, withoutRoom = false, withoutAvatar = false, perEye = false, twoViews = false,
         validate = false;
    float refreshHz = 0;
};

void note(const std::string& line) {
    std::fprintf(stderr, "%s\n", line.c_str());
}

double secondsSince(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/** The runtime with a headset, which may take a while to come. */
Result<std::unique_ptr<xr::Runtime>> waitForHeadset(const Options& options) {
    const auto start = Clock::now();
    for (bool told = false;; told = true) {
        auto runtime = xr::Runtime::create({.applicationName = "doppel-xr", .validate = options.validate});
        if (runtime) return std::move(*runtime);
        if (runtime.error().code != DPL_ERROR_NOT_FOUND || secondsSince(start) > options.waitS || interrupted)
            return fromSdk(runtime.error());
        if (!told) note(runtime.error().message);
        std::this_thread::sleep_for(300ms);
    }
}

SceneOptions sceneOf(const Options& options) {
    SceneOptions scene;
    scene.withRoom = !options.withoutRoom, scene.withAvatar = !options.withoutAvatar;
    scene.withHands = !options.withoutHands, scene.mirror = options.mirror;
    return scene;
}

xr::SessionOptions sessionOf(const Options& options) {
    xr::SessionOptions session;
    session.nearM = platform::kRoomNearM;
    session.array = !options.perEye, session.quadViews = !options.twoViews;
    session.capture = !options.capture.empty();
    session.refreshHz = options.refreshHz;
    session.blend = options.blend == "alpha" ? xr::Blend::Alpha : options.blend == "additive" ? xr::Blend::Additive : xr::Blend::Opaque;
    return session;
}

Status capture(const Options& options, const xr::Runtime& runtime, const AvatarScene& scene, const xr::Session& session) {
    const xr::Frame& last = session.lastFrame();
    DPL_TRY(const std::string text,
            writeCapture(options.capture, session.captured(), scene, {runtime.name(), options.clip, last.number, last.timeS}));
    std::fputs(text.c_str(), stdout);
    return {};
}

Status play(const Options& options, xr::Runtime& runtime, doppel::Avatar& avatar) {
    SceneOptions what = sceneOf(options);
    if (!options.clip.empty()) {
        DPL_TRY(what.clip, chooseClip(avatar, options.clip, options.animation));
    }
    auto puppet = xr::Puppet::of(avatar);
    if (!puppet) return fromSdk(puppet.error());
    AvatarScene scene(runtime, avatar, std::move(*puppet), what);
    xr::Session session(runtime, sessionOf(options));
    uint64_t drawn = 0;
    bool leaving = false;
    auto lastProgress = Clock::now();
    std::string complaint;
    for (;;) {
        if (drawn + 1 == options.frames) session.captureNextFrame();
        const auto step = session.frame(scene);
        if (!step) return fromSdk(step.error());
        if (*step == xr::Step::Ended) break;
        if (session.lastComplaint() != complaint) note(complaint = session.lastComplaint());
        if (*step == xr::Step::Lost) note("the session was lost; making a new one");
        if (*step == xr::Step::Idle || *step == xr::Step::Lost) std::this_thread::sleep_for(5ms);
        if (leaving) {
            if (secondsSince(lastProgress) > kExitSeconds) return fail(Code::Device, "the runtime does not end the session");
            continue;
        }
        if (*step == xr::Step::Drew) {
            ++drawn;
            lastProgress = Clock::now();
            if (drawn == options.frames && !options.capture.empty()) DPL_RETURN_IF_ERROR(capture(options, runtime, scene, session));
            scene.moveByControllers(session);
        }
        leaving = interrupted || (options.frames > 0 && drawn >= options.frames);
        if (leaving) session.requestExit(), lastProgress = Clock::now();
        if (options.frames > 0 && !leaving && secondsSince(lastProgress) > options.waitS)
            return fail(Code::Device, "nothing was shown for {} s after {} of {} frames; wear the headset, or raise --wait", options.waitS,
                        drawn, options.frames);
    }
    note(formatText("{} frames on {}", drawn, runtime.name()));
    if (drawn < options.frames && !interrupted) return fail(Code::Device, "the session ended after {} of {} frames", drawn, options.frames);
    return {};
}

Status run(const Options& options) {
    DPL_TRY(auto bytes, readFile(options.avatar));
    DPL_TRY(auto runtime, waitForHeadset(options));
    note("drawing with " + runtime->name());
    Status played;
    {
        DplAvatar handle = nullptr;
        if (dplLoadAvatar(runtime->context(), bytes.data(), bytes.size(), &handle) != DPL_OK)
            return fail(fromSdk(doppel::lastError(DPL_ERROR_DEVICE)).code, "{}: {}", options.avatar.string(), dplGetLastError());
        doppel::Avatar avatar(runtime->context(), handle);
        played = play(options, *runtime, avatar);
    }
    if (options.validate) {
        for (const std::string& complaint : runtime->complaints()) std::fprintf(stderr, "%s\n", complaint.c_str());
        std::printf("validation messages: %zu\n", runtime->complaintCount());
        if (played && runtime->complaintCount() > 0) return fail(Code::Device, "the validation layer complained");
    }
    return played;
}

int exitCodeOf(const Error& error) {
    std::fprintf(stderr, "doppel-xr: %s\n", error.message.c_str());
    return error.code == Code::InvalidArgument ? 2 : 1;
}

}  // namespace
}  // namespace dpl

int main(int argc, char** argv) {
    using namespace dpl;
    CLI::App app{"Shows an avatar on an OpenXR headset.", "doppel-xr"};
    Options options;
    app.add_option("avatar", options.avatar,
                   "Avatar file (.glb), or general splats (.ply, compressed .ply, .spz, .glb with KHR_gaussian_splatting)")
        ->required();
    app.add_option("--clip", options.clip, "A clip of the avatar by name, or a BVH or glTF file to drive it with");
    app.add_option("--animation", options.animation, kAnimationHelp)->needs("--clip");
    app.add_flag("--mirror", options.mirror, "The avatar is your image in a mirror: it does what your head and hands do");
    app.add_option("--blend", options.blend,
                   "opaque: a lit room around the avatar; alpha, additive: the real room, where the headset shows it")
        ->check(CLI::IsMember(kBlendNames))
        ->capture_default_str();
    app.add_option("--hz", options.refreshHz, "Refresh rate; the nearest one that the headset offers is taken")
        ->check(inRange(1.0, 1000.0));
    app.add_option("--wait", options.waitS, "How long to wait for a headset, seconds")->check(inRange(0.0, 86400.0))->capture_default_str();
    app.add_option("--frames", options.frames, "Stop after this many pictures; otherwise when the user quits")->check(inRange(1.0, 1e9));
    app.add_option("--capture", options.capture,
                   "With --frames: write the last frame to this folder (view_N.png, view_N_depth.pfm, views.json)")
        ->needs("--frames");
    app.add_flag("--without-hands", options.withoutHands, "Your hands do not move the avatar");
    app.add_flag("--without-room", options.withoutRoom, "The avatar alone over black of alpha 0");
    app.add_flag("--without-avatar", options.withoutAvatar, "The room alone");
    app.add_flag("--per-eye", options.perEye, "An image for each eye, even where one image with two layers is possible");
    app.add_flag("--two-views", options.twoViews, "No foveated insets, even where the headset has them");
    app.add_flag("--validate", options.validate, "Use the Vulkan validation layer, print its messages, and fail if there are any");
    app.footer(
        "Controllers: select puts the avatar where you point at the floor; the stick turns it.\n"
        "Hands, where the headset tracks them: the avatar's arms and fingers do what yours do. A tracked body: its upper body too.\n"
        "Examples:\n"
        "  doppel-xr ada/avatar.glb --clip dance.bvh\n"
        "  doppel-xr ada/avatar.glb --mirror\n"
        "  doppel-xr ada/avatar.glb --blend alpha          in your own room, on a headset with passthrough\n"
        "  doppel-xr ada/avatar.glb --frames 100 --capture shots\n"
        "Exit codes: 0 done, 1 failed (the sentence says why), 2 wrong arguments.");
    if (argc < 2) {
        std::fputs(app.help().c_str(), stderr);
        return 2;
    }
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == 0) return app.exit(error);  // --help
        return exitCodeOf(fail(Code::InvalidArgument, "{}. See doppel-xr --help", error.what()));
    }
    std::signal(SIGINT, [](int) {
        interrupted = 1;
        std::signal(SIGINT, SIG_DFL);  // the second one ends the process
    });
    try {
        const Status done = run(options);
        return done ? 0 : exitCodeOf(done.error());
    } catch (const std::bad_alloc&) {
        return exitCodeOf(fail(Code::OutOfMemory, "out of memory; close other programs"));
    }
}
