// SPDX-License-Identifier: Apache-2.0
// Which splats of an avatar the single-face gate hides from an eye (docs/reference/gate.md). Written splats have the gate in their opacity
// (dplWriteSplats), so they are written with the eye and without it, by an avatar of the same file that a context on the CPU holds: what a
// GPU draws stays there. That takes tens of milliseconds: it belongs on the loader's thread.
#pragma once

#include <array>
#include <doppel/doppel.hpp>
#include <filesystem>

#include "sdk/core/result.h"
#include "sdk/math/types.h"

namespace dpl {

struct ViewedSubject;

/** An avatar in its pose, and who looks at it. */
struct GateQuestion {
    DplAvatar avatar = nullptr;  // that is drawn; tells questions apart, and is not asked
    std::filesystem::path file;
    std::vector<float> rotations;  // as in dplSetPose
    std::array<float, 3> root{};
    std::vector<uint8_t> motion;        // what its clothes remember
    std::array<float, 12> transform{};  // as in dplSetTransform
    Vec3f eye{0};                       // world, metres
    bool operator==(const GateQuestion&) const = default;
};
Result<GateQuestion> gateQuestion(const ViewedSubject& subject, const Vec3d& eye);

struct HiddenSplats {
    static constexpr size_t kMostPlaces = 12000;
    std::vector<Vec3f> places;      // world, metres; of some of them, evenly spaced, where there are more
    size_t hidden = 0, splats = 0;  // splats: that the pose shows to some eye
};

class GateFinder {
public:
    Result<HiddenSplats> find(const GateQuestion& question);

private:
    Status load(const GateQuestion& question);
    DplAvatar of_ = nullptr;  // avatar and file of the last question
    std::filesystem::path file_;
    doppel::Context context_;
    doppel::Avatar twin_;
    std::vector<float> places_, seen_, all_;  // of the splats: places, opacity from the eye and from everywhere
};

}  // namespace dpl
