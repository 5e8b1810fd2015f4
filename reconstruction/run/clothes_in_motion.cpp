// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/clothes_in_motion.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "reconstruction/output/package/avatar_bytes.h"
#include "sdk/avatar/body_shape.h"
#include "sdk/core/files.h"
#include "sdk/motion/clip.h"
#include "sdk/motion/clip_memory.h"
#include "sdk/motion/motion_clip.h"

namespace dpl {
namespace {

constexpr double kPosesPerSecond = 10;
constexpr size_t kMostPoses = 200;

void addPixels(const PixelFault& outside, const PixelFault& uncovered, const std::vector<double>& timesS, nlohmann::ordered_json& out) {
    for (const auto& [key, fault] : {std::pair{"outside_tubes", outside}, {"uncovered", uncovered}})
        out[key] = {{"most_px", fault.mostPx}, {"worst_pose_s", timesS[fault.worstPose]}, {"share", fault.share}};
}

std::string pixelText(const PixelFault& fault, const std::vector<double>& timesS) {
    char text[100];
    std::snprintf(text, sizeof text, "%6.3f %%  (at most %zu pixels, at %.1f s)", 100 * fault.share, fault.mostPx, timesS[fault.worstPose]);
    return text;
}

}  // namespace

std::string clothesJson(const ClothFaults& faults, const std::filesystem::path& clip, const std::vector<double>& timesS) {
    nlohmann::ordered_json out = {{"clip", clip.string()},
                                  {"poses", timesS.size()},
                                  {"garment_vertices_inside_body", faults.penetration},
                                  {"worst_pose_s", timesS[faults.worstPose]},
                                  {"edges_stretched_over_2", faults.stretchedEdges},
                                  {"longest_stretch", faults.longestStretch},
                                  {"longest_splat_mm", 1000 * faults.longestSplatM},
                                  {"skin_in_garment_pixels", faults.skinPixels},
                                  {"offsets_at_work", faults.offsetsAtWork}};
    addPixels(faults.outside, faults.uncovered, timesS, out);
    out["garments"] = nlohmann::ordered_json::array();
    for (const GarmentNeedles& g : faults.garments) {
        out["garments"].push_back({{"name", g.name}, {"longest_stretch", g.longestStretch}, {"longest_splat_mm", 1000 * g.longestSplatM}});
        addPixels(g.outside, g.uncovered, timesS, out["garments"].back());
    }
    return out.dump(1);
}

std::string clothesText(const ClothFaults& faults, const std::filesystem::path& clip, const std::vector<double>& timesS) {
    char text[400];
    std::snprintf(text, sizeof text,
                  "clothes in %s, %zu poses\n"
                  "  garment vertices inside the body  %6.2f %%  (most at %.1f s)\n"
                  "  edges stretched over 2 x          %6.3f %%  (longest %.1f x)\n"
                  "  skin that shows through           %6.2f %% of the garments' pixels\n"
                  "  learned offsets at work           %6.0f %%",
                  clip.filename().c_str(), timesS.size(), 100 * faults.penetration, timesS[faults.worstPose], 100 * faults.stretchedEdges,
                  faults.longestStretch, 100 * faults.skinPixels, 100 * faults.offsetsAtWork);
    std::string shown = text;
    shown += "\n  drawn outside the grown tubes     " + pixelText(faults.outside, timesS);
    shown += "\n  uncovered in the outline          " + pixelText(faults.uncovered, timesS);
    for (const GarmentNeedles& g : faults.garments) {
        std::snprintf(text, sizeof text, "\n  %-24s longest edge %5.2f x, longest splat %4.0f mm", g.name.substr(0, 24).c_str(),
                      g.longestStretch, 1000 * g.longestSplatM);
        shown += text;
        shown += "\n    outside the grown tubes         " + pixelText(g.outside, timesS);
        shown += "\n    uncovered in the outline        " + pixelText(g.uncovered, timesS);
    }
    return shown;
}

Result<std::string> clothesInMotion(const std::filesystem::path& path, const std::filesystem::path& clipPath, const std::string& animation,
                                    bool json, Progress& progress) {
    DPL_TRY(const auto bytes, readAvatarBytes(path));
    const auto inFile = [](const std::filesystem::path& file, const Error& e) { return fail(e.code, "{}: {}", file.string(), e.message); };
    DPL_TRY(const AvatarData avatar, avatarOf(path, bytes, "clothes"));
    DPL_TRY(const auto clipBytes, readFile(clipPath, uint64_t(512) << 20));
    const BodyShape body = BodyShape::of(avatar.joints, avatar.mesh);  // arms give way, as in dplLoadClip
    RetargetOptions played;
    played.body = &body;
    const auto clip = readClip(clipBytes, clipPath.stem().string(), {animation}, avatar.joints, played);
    if (!clip) return inFile(clipPath, clip.error());
    const double duration = clipDurationS(*clip);
    const size_t count = std::clamp(size_t(duration * kPosesPerSecond) + 1, size_t(1), kMostPoses);
    ClipMemory memory(*clip, avatar.joints, avatar.correctives.motion);
    std::vector<double> timesS;
    std::vector<Pose> poses;
    for (size_t i = 0; i < count; ++i) {
        timesS.push_back(count > 1 ? duration * double(i) / double(count - 1) : 0);
        poses.push_back(samplePose(*clip, avatar.joints, timesS.back()));
        poses.back().before = memory.at(timesS.back(), /*loop=*/false);
    }
    Jobs jobs(0);
    progress.beginStage("clothes in motion");
    ShownTask task(progress);
    const TaskScope scope(&task);
    DPL_TRY(const ClothFaults faults, clothFaults(avatar, poses, jobs));
    progress.endStage(formatText("{} poses", count));
    return json ? clothesJson(faults, clipPath, timesS) : clothesText(faults, clipPath, timesS);
}

}  // namespace dpl
