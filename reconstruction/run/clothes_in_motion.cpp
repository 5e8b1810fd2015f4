// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/clothes_in_motion.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "reconstruction/output/package/avatar_bytes.h"
#include "reconstruction/subject/garments/cloth_faults.h"
#include "sdk/avatar/body_shape.h"
#include "sdk/core/files.h"
#include "sdk/motion/clip.h"
#include "sdk/motion/motion_clip.h"

namespace dpl {
namespace {

constexpr double kPosesPerSecond = 10;
constexpr size_t kMostPoses = 200;

nlohmann::ordered_json needlesOf(const ClothFaults& faults) {
    auto garments = nlohmann::ordered_json::array();
    for (const GarmentNeedles& g : faults.garments)
        garments.push_back({{"name", g.name}, {"longest_stretch", g.longestStretch}, {"longest_splat_mm", 1000 * g.longestSplatM}});
    return garments;
}

}  // namespace

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
    const auto timeOf = [&](size_t i) { return count > 1 ? duration * double(i) / double(count - 1) : 0; };
    std::vector<Pose> poses;
    for (size_t i = 0; i < count; ++i) poses.push_back(samplePose(*clip, avatar.joints, timeOf(i)));
    Jobs jobs(0);
    progress.beginStage("clothes in motion");
    ShownTask task(progress);
    const TaskScope scope(&task);
    DPL_TRY(const ClothFaults faults, clothFaults(avatar, poses, jobs));
    progress.endStage(formatText("{} poses", count));
    if (json)
        return nlohmann::ordered_json{{"clip", clipPath.string()},
                                      {"poses", count},
                                      {"garment_vertices_inside_body", faults.penetration},
                                      {"worst_pose_s", timeOf(faults.worstPose)},
                                      {"edges_stretched_over_2", faults.stretchedEdges},
                                      {"longest_stretch", faults.longestStretch},
                                      {"longest_splat_mm", 1000 * faults.longestSplatM},
                                      {"skin_in_garment_pixels", faults.skinPixels},
                                      {"garments", needlesOf(faults)}}
            .dump(1);
    char text[400];
    std::snprintf(text, sizeof text,
                  "clothes in %s, %zu poses\n"
                  "  garment vertices inside the body  %6.2f %%  (most at %.1f s)\n"
                  "  edges stretched over 2 x          %6.3f %%  (longest %.1f x)\n"
                  "  skin that shows through           %6.2f %% of the garments' pixels",
                  clipPath.filename().c_str(), count, 100 * faults.penetration, timeOf(faults.worstPose), 100 * faults.stretchedEdges,
                  faults.longestStretch, 100 * faults.skinPixels);
    std::string shown = text;
    for (const GarmentNeedles& g : faults.garments) {
        std::snprintf(text, sizeof text, "\n  %-24s longest edge %5.2f x, longest splat %4.0f mm", g.name.substr(0, 24).c_str(),
                      g.longestStretch, 1000 * g.longestSplatM);
        shown += text;
    }
    return shown;
}

}  // namespace dpl
