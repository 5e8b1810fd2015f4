// SPDX-License-Identifier: Apache-2.0
// doppel render: draws stills, turntables, clips and stereo pairs of an avatar, or every frame of a scan from the scan's own cameras.
#include <chrono>
#include <cmath>
#include <numbers>
#include <set>

#include "apps/doppel/commands.h"
#include "apps/doppel/talk.h"
#include "apps/shared/checks.h"
#include "apps/shared/pictures.h"
#include "apps/shared/video_writer.h"
#include "reconstruction/base/image_codec.h"
#include "reconstruction/judging/report/draw_view.h"
#include "reconstruction/output/package/avatar_bytes.h"
#include "reconstruction/run/film_memory.h"
#include "reconstruction/run/frame_table.h"
#include "reconstruction/run/run_scan.h"
#include "sdk/core/files.h"
#include "sdk/core/numbers.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

size_t millisecondsSince(Clock::time_point start) {
    return size_t(std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - start).count());
}

struct RenderOptions {
    fs::path avatar, out, scan, poses;
    std::vector<fs::path> beside;
    std::vector<std::string> expression;  // NAME=WEIGHT
    std::string clip, animation, split = "test", size = "720x1280", renderer = "auto", fill = "auto", axes;
    double apartM = 0.8, timeS = 0, seconds = 0, framesPerSecond = 30, azimuthDeg = 0, scale = 1;
    double splatsPerPixel = 0;
    bool turntable = false, stereo = false, unfitted = false;
    uint32_t threadCount = 0, splatBudget = 0;
};

Result<doppel::Context> makeContext(const RenderOptions& options) {
    const DplRenderer kind = options.renderer == "software" ? DPL_RENDERER_SOFTWARE
                             : options.renderer == "vulkan" ? DPL_RENDERER_VULKAN
                                                            : DPL_RENDERER_AUTO;
    auto context = doppel::Context::create(kind, options.threadCount, 0, fillOf(options.fill));
    if (!context) return fromSdk(context.error());
    if (auto set = context->setDetail(float(options.splatsPerPixel), options.splatBudget); !set) return fromSdk(set.error());
    return std::move(*context);
}

Status writePng(const fs::path& path, std::span<const uint8_t> pixels, uint32_t widthPx, uint32_t heightPx, uint32_t channels) {
    DPL_TRY(auto png, encodePng(pixels, widthPx, heightPx, channels));
    return writeFileAtomically(path, png);
}

Status makeFolder(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) return fail(Code::Io, "cannot create {}: {}", folder.string(), error.message());
    return {};
}

struct Drawn {
    size_t frames = 0, empty = 0;  // empty: no splat covers a pixel
};

/** Makes the folder for frames, without those of an earlier run: fewer frames than before would leave some among the new ones. */
Status makeFrameFolder(const fs::path& folder, const std::function<bool(const std::string&)>& isFrame, Progress& progress) {
    DPL_RETURN_IF_ERROR(makeFolder(folder));
    DPL_TRY(const size_t removed, removeFrames(folder, isFrame));
    if (removed > 0) progress.note(formatText("removed {} frames of an earlier run from {}", removed, folder.string()));
    return {};
}

/** --scan: one PNG with straight alpha per frame, named like the frame, from the camera of the reconstruction and the pose found for it. */
Result<Drawn> renderScan(const RenderOptions& options, const doppel::Context& context, doppel::Avatar& avatar, Progress& progress) {
    const fs::path posesPath = options.poses.empty() ? options.avatar.parent_path() / "poses.json" : options.poses;
    DPL_TRY(RunScan run, readRunScan(options.scan, posesPath));
    DPL_TRY(const auto bytes, readAvatarBytes(options.avatar));
    DPL_TRY(const AvatarData data, avatarOf(options.avatar, bytes, "poses"));
    const MotionModeData& motion = data.correctives.motion;
    rememberPoses(run.scan, motion, run.poses);
    std::vector<size_t> frames;
    for (size_t f = 0; f < run.scan.frames.size(); ++f)
        if (options.split == "all" || splitName(run.scan.frames[f].split) == options.split) frames.push_back(f);
    if (frames.empty()) return fail(Code::NotFound, "{} has no frames of split '{}'", posesPath.string(), options.split);
    std::set<std::string> names;  // of all splits: frames of another one would be scored with these
    for (const ScanFrame& frame : run.scan.frames) names.insert(frame.name);
    DPL_RETURN_IF_ERROR(makeFrameFolder(
        options.out, [&](const std::string& name) { return names.contains(name); }, progress));
    Drawn drawn{frames.size()};
    progress.beginStage("render");
    for (size_t i = 0; i < frames.size(); ++i) {
        if (progress.cancelled()) return fail(Code::Cancelled, "stopped after {} of {} frames", i, frames.size());
        const FramePose& found = run.poses.frames[frames[i]];
        const Pose& pose = found.fittedPose && !options.unfitted ? *found.fittedPose : found.pose;
        static_assert(sizeof(Quatf) == 4 * sizeof(float), "GLM keeps quaternions as xyzw");
        if (auto set = avatar.setPose({&pose.localRotations[0].x, pose.localRotations.size() * 4}, {&pose.rootTranslation.x, 3}); !set)
            return fromSdk(set.error());
        if (auto set = avatar.setMotionState(motionStateBytes(motion, pose)); !set) return fromSdk(set.error());
        const Cameraf camera = run.cameras[frames[i]].scaled(options.scale).cast<float>();
        const DplAvatar row[1] = {avatar.handle()};
        DPL_TRY(auto pixels, drawViews(context, row, {&camera, 1}));
        drawn.empty += isEmpty(pixels);
        DPL_RETURN_IF_ERROR(writePng(options.out / (found.name + ".png"), pixels[0], camera.widthPx, camera.heightPx, 4));
        progress.update(double(i + 1) / double(frames.size()), found.name);
    }
    progress.endStage(formatText("{} pictures in {}", frames.size(), options.out.string()));
    return drawn;
}

/** The avatars that are drawn together, and the clip that each of them plays. */
struct Company {
    std::vector<doppel::Avatar> avatars;
    std::vector<Mat3d> uprights;  // from the axes of each loaded file
    std::vector<uint32_t> clips;
    std::vector<DplAvatar> row;
};

/** Stands the avatars upright in a row, and general splats where their file says. Returns the box of all in one DplAvatarInfo. */
Result<DplAvatarInfo> standInRow(Company& company, double apartM) {
    DplAvatarInfo all{};
    for (size_t i = 0; i < company.avatars.size(); ++i) {
        auto info = company.avatars[i].info();
        if (!info) return fromSdk(info.error());
        const double asideM = info->jointCount > 0 ? apartM * (double(i) - 0.5 * double(company.avatars.size() - 1)) : 0;
        const Mat3d& upright = company.uprights[i];
        if (auto set = company.avatars[i].setTransform(standing(upright, asideM)); !set) return fromSdk(set.error());
        const Vec3d aside(asideM, 0, 0), a = upright * Vec3d(info->restMin[0], info->restMin[1], info->restMin[2]) + aside,
                                         b = upright * Vec3d(info->restMax[0], info->restMax[1], info->restMax[2]) + aside;
        if (i == 0) all = *info;
        for (int k = 0; k < 3; ++k) {
            const float low = float(std::min(a[k], b[k])), high = float(std::max(a[k], b[k]));
            all.restMin[k] = i == 0 ? low : std::min(all.restMin[k], low);
            all.restMax[k] = i == 0 ? high : std::max(all.restMax[k], high);
        }
    }
    return all;
}

/** Sets the face of every avatar by --expression. */
Status express(const RenderOptions& options, Company& company) {
    std::vector<std::string> words;
    std::vector<const char*> names;
    std::vector<float> weights;
    for (const std::string& given : options.expression) {
        const size_t equals = given.find('=');
        float weight = 0;
        if (equals == std::string::npos || !readNumber(std::string_view(given).substr(equals + 1), weight))
            return fail(Code::InvalidArgument, "--expression {}: name a weight like jawOpen=0.5", given);
        words.push_back(given.substr(0, equals)), weights.push_back(weight);
    }
    for (const std::string& word : words) names.push_back(word.c_str());
    for (doppel::Avatar& avatar : company.avatars)
        if (auto set = avatar.setExpression(names, weights); !set) return fromSdk(set.error());
    return {};
}

/** Stills, turntables and clips, from a camera that frames all avatars. */
Result<Drawn> renderShots(const RenderOptions& options, const doppel::Context& context, Company& company, Progress& progress) {
    const PictureSize size = parsePictureSize(options.size).value_or(PictureSize{});  // the option parser has checked it
    double duration = options.turntable ? 6 : 0;
    for (size_t i = 0; i < company.avatars.size(); ++i) {
        doppel::Avatar& avatar = company.avatars[i];
        company.row.push_back(avatar.handle());
        company.clips.push_back(0);
        if (options.clip.empty()) continue;
        DPL_TRY(company.clips[i], chooseClip(avatar, options.clip, options.animation));
        auto about = avatar.clip(company.clips[i]);
        if (!about) return fromSdk(about.error());
        duration = std::max(duration, about->durationS);
    }
    if (!options.expression.empty()) DPL_RETURN_IF_ERROR(express(options, company));
    DPL_TRY(const DplAvatarInfo box, standInRow(company, options.apartM));
    if (options.seconds > 0) duration = options.seconds;

    const std::string extension = options.out.extension().string();
    const bool still = extension == ".png", video = extension == ".mp4";
    const size_t frameCount = still ? 1 : std::max<size_t>(1, size_t(std::lround(duration * options.framesPerSecond)));
    Drawn drawn{frameCount};
    const uint32_t viewCount = options.stereo ? 2 : 1, outWidthPx = size.widthPx * viewCount;
    if (video && (outWidthPx % 2 || size.heightPx % 2))
        return fail(Code::InvalidArgument, "--size {}: a video needs an even width and height, like 720x1280", options.size);
    if (!still && !video) DPL_RETURN_IF_ERROR(makeFrameFolder(options.out, isFrameNumber, progress));
    std::optional<VideoWriter> writer;
    if (video) {
        DPL_TRY(auto opened, VideoWriter::open(options.out, outWidthPx, size.heightPx, options.framesPerSecond));
        writer.emplace(std::move(opened));
    }
    progress.beginStage("render");
    for (size_t i = 0; i < frameCount; ++i) {
        if (progress.cancelled()) return fail(Code::Cancelled, "stopped after {} of {} frames", i, frameCount);
        const double timeS = options.timeS + double(i) / options.framesPerSecond;
        for (size_t k = 0; k < company.avatars.size() && !options.clip.empty(); ++k)
            if (auto set = company.avatars[k].setPoseFromClip(company.clips[k], timeS, true); !set) return fromSdk(set.error());
        const double turn = options.turntable ? 2 * std::numbers::pi * double(i) / double(frameCount) : 0;
        const Cameraf centre = frameAvatar(box, size.widthPx, size.heightPx, options.azimuthDeg * std::numbers::pi / 180 + turn);
        std::vector<Cameraf> views = {centre};
        if (options.stereo) views = {shiftedSideways(centre, -kEyeDistanceM / 2), shiftedSideways(centre, kEyeDistanceM / 2)};
        DPL_TRY(auto pixels, drawViews(context, company.row, views));
        drawn.empty += isEmpty(pixels);
        if (still && !options.stereo) {
            DPL_RETURN_IF_ERROR(writePng(options.out, pixels[0], size.widthPx, size.heightPx, 4));
        } else {
            const std::vector<uint8_t> rgb = sideBySide(pixels, size.widthPx, size.heightPx);
            DPL_RETURN_IF_ERROR(
                video ? writer->write(rgb)
                      : writePng(still ? options.out : options.out / (frameNumber(i) + ".png"), rgb, outWidthPx, size.heightPx, 3));
        }
        progress.update(double(i + 1) / double(frameCount), formatText("frame {} of {}", i + 1, frameCount));
    }
    if (writer) DPL_RETURN_IF_ERROR(writer->finish());
    std::string kept;
    if (options.splatsPerPixel > 0 || options.splatBudget > 0) {
        auto stats = company.avatars[0].frameStats();
        if (!stats) return fromSdk(stats.error());
        kept = formatText(", at most {} splats in the last frame, {} of them in view", stats->splatsAllowed, stats->splatsDrawn);
    }
    progress.endStage(formatText("{} {} in {}{}", frameCount, frameCount == 1 ? "frame" : "frames", options.out.string(), kept));
    return drawn;
}

/** Refuses options that would pose general splats, because these have no joints. */
Status checkStill(const RenderOptions& options, const fs::path& file) {
    const char* posing = !options.clip.empty() ? "--clip" : !options.scan.empty() ? "--scan" : options.timeS > 0 ? "--time" : nullptr;
    if (posing)
        return fail(Code::InvalidArgument, "{}: {} holds general splats, which have no joints to pose; leave the option out", posing,
                    file.string());
    return {};
}

/** Why --out cannot be written, or does not go with the other options. Empty if it can. */
std::string wrongOutput(const RenderOptions& options) {
    std::string out = options.out.string();
    const std::string extension = options.out.extension().string();
    if (options.scan.empty()) {
        if (extension == ".png" && (options.turntable || options.seconds > 0))
            return formatText("{} is one picture, and {} makes many; name a .mp4 or a folder", out,
                              options.turntable ? "--turntable" : "--seconds");
        return isOutputFile({".png", ".mp4"}, /*orFolder=*/true)(out);
    }
    if (extension == ".png" || extension == ".mp4")
        return formatText("{}: with --scan the output is a folder of PNG files; name a folder", out);
    return {};
}

/** Names the output if the user has not. Says why it cannot be named so: a file that nobody named is never overwritten. */
std::string nameOutput(RenderOptions& options) {
    if (!options.out.empty()) return {};
    if (!options.scan.empty()) return "--scan draws many pictures; name a folder for them";
    options.out = options.avatar.stem();
    options.out += options.turntable || options.seconds > 0 ? ".mp4" : ".png";
    std::error_code ignored;
    return fs::exists(options.out, ignored) ? formatText("{} is there already; name another file, or this one", options.out.string()) : "";
}

/** What was drawn, as JSON. */
Result<nlohmann::json> renderAll(const RenderOptions& options, const Talk& talk) {
    Progress progress(talk.style());
    std::vector<fs::path> files = {options.avatar};
    files.insert(files.end(), options.beside.begin(), options.beside.end());
    DPL_TRY(auto context, makeContext(options));
    Company company;
    uint64_t splats = 0;
    for (const fs::path& file : files) {
        const auto start = Clock::now();
        auto avatar = context.loadAvatarFile(file.string());
        if (!avatar) return fromSdk(avatar.error());
        auto info = avatar->info();
        if (!info) return fromSdk(info.error());
        if (info->jointCount == 0) DPL_RETURN_IF_ERROR(checkStill(options, file));
        auto axes = avatar->fileAxes();
        if (!axes) return fromSdk(axes.error());
        if (!axes->stated && options.axes.empty()) progress.note(formatText("{}: {}", file.string(), kNoUpAxis));
        company.uprights.push_back(uprightFromLoaded(options.axes, loadedFromFile(*axes)));
        progress.detail(formatText("{}: {} splats of {}, loaded in {} ms", file.string(), info->splatCount, info->fileSplatCount,
                                   millisecondsSince(start)));
        splats += info->splatCount;
        company.avatars.push_back(std::move(*avatar));
    }
    progress.note("drawing with " + context.rendererName());
    const auto start = Clock::now();
    DPL_TRY(const Drawn drawn, options.scan.empty() ? renderShots(options, context, company, progress)
                                                    : renderScan(options, context, company.avatars[0], progress));
    const size_t frames = drawn.frames;
    if (drawn.empty > 0)
        progress.note(formatText("nothing is drawn in {} of {} {}: no splat covers a pixel ({} splats loaded)", drawn.empty, frames,
                                 frames == 1 ? "picture" : "pictures", splats));
    if (const auto stats = company.avatars[0].frameStats())
        progress.detail(formatText("{} ms a frame with writing it, {} splats drawn in the last one, {} MiB held by the renderer",
                                   millisecondsSince(start) / std::max<size_t>(1, frames), stats->splatsDrawn, stats->residentBytes >> 20));
    return nlohmann::json{
        {"out", options.out.string()}, {"frames", frames}, {"empty_frames", drawn.empty}, {"renderer", context.rendererName()}};
}

}  // namespace

void addRenderCommand(CLI::App& app, CommandRun& run) {
    auto options = std::make_shared<RenderOptions>();
    CLI::App* command = app.add_subcommand("render", "Draw an avatar: stills, turntables, clips, stereo, or a scan's own views");
    command
        ->add_option("avatar", options->avatar,
                     "Avatar file (.glb), or general splats (.ply, compressed .ply, .spz, .glb with KHR_gaussian_splatting)")
        ->required();
    command->add_option(
        "-o,--out", options->out,
        "A .png (with alpha), a .mp4 (through ffmpeg) or a folder of PNG frames (default: the avatar's name with .png, or .mp4 for "
        "--turntable and --seconds, in this folder)");
    command->add_option("--with", options->beside, "More avatars in the same picture, side by side; their splats are sorted together")
        ->expected(1, int(DPL_MAX_TOGETHER) - 1);
    command->add_option("--apart", options->apartM, "Distance between neighbours, metres")
        ->check(inRange(0.0, 100.0))
        ->capture_default_str()
        ->needs("--with");
    command->add_option("--clip", options->clip, "A clip of the avatar by name, or a BVH or glTF file to drive it with");
    command->add_option("--animation", options->animation, kAnimationHelp)->needs("--clip");
    command->add_option("--time", options->timeS, "Start time in the clip, seconds")->check(inRange(0.0, 1e6));
    command->add_option("--seconds", options->seconds, "Length of the video (default: the clip's, or 6 s for a turntable)")
        ->check(inRange(0.0, 3600.0));
    command->add_option("--fps", options->framesPerSecond, "Frames per second")->check(inRange(1.0, 240.0))->capture_default_str();
    command->add_option("--expression", options->expression,
                        "What the face shows, such as mouthSmileLeft=0.8 jawOpen=0.3: names of ARKit or VRM, weights 0 to 1");
    command->add_flag("--turntable", options->turntable, "Move the camera once around the avatar");
    command->add_option("--azimuth", options->azimuthDeg, "Angle of the camera around the avatar, degrees; 0: from the front")
        ->check(inRange(-360.0, 360.0));
    command->add_option("--axes", options->axes, kAxesHelp)->check(CLI::IsMember(kAxesNames));
    command->add_flag("--stereo", options->stereo, "Left and right eye side by side, 63 mm apart");
    command->add_option("--size", options->size, "Size of one view")->check(isPictureSize())->capture_default_str();
    command->add_option("--scan", options->scan, "Draw the frames of this scan from its own cameras, one PNG with alpha for each frame");
    for (const char* other : {"--with", "--clip", "--time", "--seconds", "--expression", "--turntable", "--azimuth", "--stereo", "--size"})
        command->get_option("--scan")->excludes(other);
    command->add_option("--split", options->split, "With --scan: which frames to draw")
        ->check(CLI::IsMember({"test", "validation", "train", "all"}))
        ->capture_default_str()
        ->needs("--scan");
    command->add_option("--poses", options->poses, "With --scan: poses.json of the reconstruction (default: beside the avatar)")
        ->needs("--scan");
    command->add_option("--scale", options->scale, "With --scan: size of the pictures as a multiple of the scan's")
        ->check(inRange(0.05, 16.0))
        ->capture_default_str()
        ->needs("--scan");
    command->add_flag("--without-pose-fit", options->unfitted, "With --scan: draw held-out frames in the poses from before the pose fit")
        ->needs("--scan");
    command->add_option("--renderer", options->renderer, "auto: a GPU if there is one, otherwise the CPU")
        ->check(CLI::IsMember({"auto", "software", "vulkan"}))
        ->capture_default_str();
    command->add_option("--fill", options->fill, "How a GPU fills pixels; auto: a self-test chooses the faster way")
        ->check(CLI::IsMember(kFillNames))
        ->capture_default_str();
    command
        ->add_option(
            "--splats-per-pixel", options->splatsPerPixel,
            formatText("Level of detail: the most splats to keep for each pixel; {} is hard to tell from all splats, 0: all splats",
                       DPL_DETAIL_USUAL))
        ->check(inRange(0.0, 1e6));
    command->add_option("--splat-budget", options->splatBudget, "The most splats to draw for all avatars together; 0: no limit")
        ->check(isWholeNumber(UINT32_MAX));
    command->add_option("--threads", options->threadCount, "CPU threads; 0: one for each core")->check(inRange(0, 256));
    const auto talk = addTalkOptions(*command);
    command->footer(
        "Examples:\n"
        "  doppel render ada.glb                                               (writes ada.png)\n"
        "  doppel render ada/avatar.glb -o ada.png --azimuth 30\n"
        "  doppel render ada/avatar.glb -o ada.mp4 --turntable\n"
        "  doppel render ada/avatar.glb -o walk.mp4 --clip 02_01.bvh --stereo --size 960x1080\n"
        "  doppel render ada/avatar.glb -o dance.mp4 --with bob/avatar.glb --clip dance.bvh --size 1280x720\n"
        "  doppel render ada/avatar.glb -o room.png --with bob/avatar.glb cleo/avatar.glb --size 480x270 --splats-per-pixel 12 "
        "--splat-budget 100000\n"
        "  doppel render guitar.compressed.ply -o guitar.mp4 --turntable --axes y-down\n"
        "  doppel render ada/avatar.glb -o views --scan scan --split test      (score them with your own tools)");
    command->callback([options, talk, &run] {
        if (const std::string wrong = nameOutput(*options); !wrong.empty()) throw CLI::ValidationError("-o", wrong);
        if (const std::string wrong = wrongOutput(*options); !wrong.empty()) throw CLI::ValidationError("--out", wrong);
        run = [options, talk] {
            const auto drawn = renderAll(*options, *talk);
            return drawn ? talk->succeed("", *drawn) : talk->fail(drawn.error());
        };
    });
}

}  // namespace dpl
