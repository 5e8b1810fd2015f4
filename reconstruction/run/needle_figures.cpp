// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/needle_figures.h"

#include "reconstruction/judging/coach/move_poses.h"
#include "reconstruction/run/film_memory.h"
#include "reconstruction/subject/garments/cloth_faults.h"
#include "sdk/avatar/stress_poses.h"
#include "sdk/core/evenly_spaced.h"

namespace dpl {
namespace {

constexpr double kLongestEdge = 2;  // bar: of a garment, over its rest length
constexpr size_t kMovePoses = 8;

/** The figures of one set of poses. */
struct NeedleGroup {
    std::string key, name;
    std::optional<ReportBar> edgeBar;

    void add(const GarmentNeedles& n, ReportData& data) const {
        const std::string own = key + "." + n.name;
        data.figures.push_back({own + ".edge", name, n.name + ", longest edge over its rest length", "", n.longestStretch, edgeBar});
        data.figures.push_back({own + ".splat", name, n.name + ", longest splat", "mm", 1000 * n.longestSplatM, {}});
        const auto addPixels = [&](const std::string& part, const std::string& what, const std::string& of, const PixelFault& fault) {
            data.figures.push_back(
                {own + "." + part + ".most", name, n.name + ", " + what + ", worst pose", "pixels", double(fault.mostPx), {}});
            data.figures.push_back({own + "." + part + ".share", name, n.name + ", " + what, of, 100 * fault.share, {}});
        };
        addPixels("outside", "drawn outside the grown tubes", "% of its pixels", n.outside);
        addPixels("uncovered", "uncovered in its outline", "% of its outline", n.uncovered);
    }
};

}  // namespace

void addNeedleFigures(const AvatarData& avatar, Jobs& jobs, ReportData& data) {
    const auto measure = [&](const NeedleGroup& group, const std::vector<Pose>& poses) {
        for (const GarmentNeedles& needles : clothNeedles(avatar, poses, jobs)) group.add(needles, data);
    };
    measure({"needles", "clothes in the stress poses", ReportBar{kLongestEdge, /*atLeast=*/false}}, stressPoses(avatar.joints));
    for (const MoveClip& move : moveClips(avatar.joints)) {
        const std::string name(move.name);
        measure({"needles_" + name, "clothes of the avatar " + name, {}},
                evenlySpaced(posesInLoop(avatar.correctives.motion, move), kMovePoses));
    }
}

}  // namespace dpl
