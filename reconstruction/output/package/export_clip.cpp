// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/export_clip.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "reconstruction/output/package/avatar_bytes.h"
#include "reconstruction/output/package/exported_motion.h"
#include "reconstruction/output/package/splat_target.h"
#include "reconstruction/output/package/without_gate.h"
#include "sdk/avatar/cloth_bounds.h"
#include "sdk/core/files.h"
#include "sdk/core/task.h"
#include "sdk/format/avatar_file.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

constexpr const char* kAbout = "clip.json";
constexpr size_t kMaxFrames = 100000;  // file names have five digits
constexpr size_t kGatePoses = 4;       // of the clip, for withoutGate
constexpr double kLookShare = 0.4;     // of the progress: withoutGate

/** A number of all bytes, the same on every machine (FNV-1a, 64 bits). */
std::string digestOf(std::span<const uint8_t> bytes) {
    uint64_t hash = 0xcbf29ce484222325;
    for (const uint8_t byte : bytes) hash = (hash ^ byte) * 0x100000001b3;
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
    return text;
}

std::string sizeText(double bytes) {
    const char* const units[] = {"KiB", "MiB", "GiB"};
    size_t unit = 0;
    for (bytes /= 1024; bytes >= 1024 && unit < 2; ++unit) bytes /= 1024;
    char text[32];
    std::snprintf(text, sizeof text, "%.1f %s", bytes, units[unit]);
    return text;
}

Result<std::string> digestOfClip(const AvatarData& avatar, const std::string& clip) {
    for (const ClipData& own : avatar.clips)
        if (own.name == clip) return std::string("of the avatar");
    DPL_TRY(const auto bytes, readFile(clip, uint64_t(512) << 20));
    return digestOf(bytes);
}

/** What a killed run leaves of a file that it was writing (writeFileAtomically). */
bool isHalfWritten(const fs::path& file) {
    const std::string name = file.filename().string();
    const size_t part = name.rfind(".part");
    if (part == name.npos || part + 5 == name.size() || name.find_first_not_of("0123456789", part + 5) != name.npos) return false;
    return name.compare(0, part, kAbout) == 0 || (part > 5 && name.find_first_not_of("0123456789") == 5 && name[5] == '.');
}

/** Whether the folder may be written: it is not there, or empty, or was begun with the same text. */
Status checkFolder(const fs::path& folder, const std::string& about) {
    std::error_code error;
    if (!fs::exists(folder, error)) return {};
    if (!fs::is_directory(folder, error))
        return fail(Code::InvalidArgument, "-o {} is a file; with --fps it names a folder", folder.string());
    const fs::directory_iterator files(folder, error);
    if (error) return fail(Code::Io, "-o {}: the folder cannot be read: {}", folder.string(), error.message());
    if (std::all_of(begin(files), end(files), [](const fs::directory_entry& file) { return isHalfWritten(file.path()); })) return {};
    const auto held = readFile(folder / kAbout, 1 << 20);
    if (!held)
        return fail(Code::InvalidArgument, "-o {}: the folder is not empty, and holds no clip of doppel; name another one",
                    folder.string());
    if (std::string(held->begin(), held->end()) == about) return {};
    std::string other = "another clip";
    const auto json = nlohmann::json::parse(held->begin(), held->end(), nullptr, /*allow_exceptions=*/false);
    if (json.is_object() && json.contains("clip") && json["clip"].is_string())
        other = formatText("another export, of the clip '{}'", json["clip"].get<std::string>());
    return fail(Code::InvalidArgument, "-o {}: the folder holds {} ({} tells); name another folder, or delete this one", folder.string(),
                other, kAbout);
}

}  // namespace

struct ClipExport::State {
    ExportOptions options;
    SplatTarget target = SplatTarget::None;
    AvatarData avatar, ungated;
    std::unique_ptr<ExportedMotion> motion;
    size_t frames = 0;
    std::string about;
    std::vector<Pose> gatePoses;
    uint64_t frameBytes = 0;  // of the first frame, with all splats
    std::vector<std::string> lost;

    fs::path fileOf(size_t frame) const {
        char name[32];
        std::snprintf(name, sizeof name, "%05zu.%s", frame, options.format.c_str());
        return options.out / name;
    }
    bool has(size_t frame) const {
        std::error_code error;
        return fs::is_regular_file(fileOf(frame), error);
    }
    size_t there() const {
        size_t count = 0;
        for (size_t f = 0; f < frames; ++f) count += has(f);
        return count;
    }
    Result<std::vector<uint8_t>> frame(SplatPoser& poser, size_t index) {
        DPL_TRY(const StaticSplatData splats, poser.in(motion->at(double(index) / options.fps), /*all=*/true));
        std::vector<std::string> again;
        return splatFileOf(splats, target, options, again);
    }
};

ClipExport::ClipExport(std::unique_ptr<State> state) : state_(std::move(state)) {}
ClipExport::~ClipExport() = default;

Result<std::unique_ptr<ClipExport>> ClipExport::open(const ExportOptions& options) {
    if (const std::string wrong = wrongExport(options); !wrong.empty()) return fail(Code::InvalidArgument, "{}", wrong);
    auto state = std::make_unique<State>();
    State& s = *state;
    s.options = options;
    s.target = splatTargetOf("x." + options.format);
    DPL_TRY(const auto bytes, readAvatarBytes(options.avatar));
    DPL_TRY(s.avatar, avatarOf(options.avatar, bytes, "clips"));
    boundGarments(s.avatar.joints, s.avatar.mesh);  // as renderers load it
    s.motion = std::make_unique<ExportedMotion>(s.avatar);
    DPL_RETURN_IF_ERROR(s.motion->open(options.clip, options.animation));
    const double durationS = s.motion->durationS();
    if (durationS * options.fps >= double(kMaxFrames - 1))
        return fail(Code::InvalidArgument, "{} s at {} frames a second are more than {} files; lower --fps", durationS, options.fps,
                    kMaxFrames);
    s.frames = size_t(std::floor(durationS * options.fps + 1e-6)) + 1;
    DPL_TRY(const std::string clipDigest, digestOfClip(s.avatar, options.clip));
    s.about =
        nlohmann::ordered_json{{"clip", s.motion->clip()->name},  {"clipDigest", clipDigest},       {"animation", options.animation},
                               {"avatarDigest", digestOf(bytes)}, {"framesPerSecond", options.fps}, {"frames", s.frames},
                               {"format", options.format},        {"axes", options.axes},           {"spzVersion", options.spzVersion}}
            .dump(2, ' ', false, nlohmann::json::error_handler_t::replace) +
        "\n";
    DPL_RETURN_IF_ERROR(checkFolder(options.out, s.about));

    const size_t looks = std::min(kGatePoses, s.frames);
    for (size_t k = 0; k < looks; ++k) {
        s.gatePoses.push_back(s.motion->at(looks > 1 ? durationS * double(k) / double(looks - 1) : 0));
        DPL_RETURN_IF_ERROR(checkPose(s.avatar.joints, s.gatePoses.back()));
    }
    // Leaving out what never shows takes a while; the size is said before.
    DPL_TRY(const StaticSplatData first, SplatPoser(s.avatar).in(s.gatePoses[0], /*all=*/true));
    DPL_TRY(const auto file, splatFileOf(first, s.target, options, s.lost));
    s.frameBytes = file.size();
    return std::unique_ptr<ClipExport>(new ClipExport(std::move(state)));
}

std::string ClipExport::plan() const {
    const State& s = *state_;
    const size_t there = s.there();
    const double bytes = double(s.frameBytes);
    std::string text = formatText("{} frames of at most {} splats, about {} each and {} in all, in {}", s.frames, s.avatar.splats.count(),
                                  sizeText(bytes), sizeText(bytes * double(s.frames)), s.options.out.string());
    if (there > 0) text += formatText("; {} of them are there already", there);
    return text;
}

Result<std::string> ClipExport::write() {
    State& s = *state_;
    std::error_code error;
    fs::create_directories(s.options.out, error);
    if (error) return fail(Code::Io, "{}: the folder cannot be made: {}", s.options.out.string(), error.message());
    DPL_RETURN_IF_ERROR(checkFolder(s.options.out, s.about));
    DPL_RETURN_IF_ERROR(writeFileAtomically(s.options.out / kAbout, s.about));
    std::vector<fs::path> halfWritten;
    for (const fs::directory_entry& file : fs::directory_iterator(s.options.out, error))
        if (isHalfWritten(file.path())) halfWritten.push_back(file.path());
    for (const fs::path& file : halfWritten) fs::remove(file, error);
    if (s.there() == s.frames) return formatText("all {} frames are there already, in {}", s.frames, s.options.out.string());
    {
        const TaskPart part(0, kLookShare);
        Jobs jobs(s.options.threadCount);
        DPL_TRY(s.ungated, withoutGate(s.avatar, s.gatePoses, jobs));
    }
    const TaskPart part(kLookShare, 1);
    SplatPoser poser(s.ungated, kSunkM);
    uint64_t bytes = 0;
    size_t written = 0;
    for (size_t f = 0; f < s.frames; ++f) {
        DPL_RETURN_IF_ERROR(taskAt(double(f) / double(s.frames), formatText("frame {} of {}", f + 1, s.frames)));
        if (s.has(f)) continue;
        DPL_TRY(const auto file, s.frame(poser, f));
        DPL_RETURN_IF_ERROR(writeFileAtomically(s.fileOf(f), file));
        bytes += file.size(), ++written;
    }
    std::string text;
    if (const uint32_t left = s.avatar.splats.count() - s.ungated.splats.count())
        text += formatText("note: {} splats are left out: they only show from inside, which other viewers do not hide\n", left);
    for (const std::string& lost : s.lost) text += formatText("not in the files: {}\n", lost);
    text += formatText("{} of {} frames written, {} bytes, in {}\n", written, s.frames, bytes, s.options.out.string());
    return text + viewersFor(s.target, s.options);
}

}  // namespace dpl
