// SPDX-License-Identifier: Apache-2.0
// Reads the conformance kit and draws it with one of Doppel's renderers. Links little, so that it can be built for other systems
// (tools/prove-aarch64, tools/prove-windows).
#pragma once

#include <doppel/doppel.hpp>

#include <filesystem>
#include <string>
#include <vector>

#include "sdk/core/result.h"
#include "tests/conformance/cases.h"

namespace dpl {

constexpr int kKitVersion = 2;

/** One picture that a renderer must draw. */
struct KitView {
    std::string picture;  // file name: NAME.png, or NAME.left.png and NAME.right.png
    Cameraf camera;
};

/** A pose that is drawn before that of a case. */
struct KitEarlierPose {
    std::vector<float> rotations;
    int64_t timeNs = 0;
};

struct KitCase {
    std::string name, about, avatarFile;
    std::vector<float> rotations;  // one xyzw quaternion per joint, as in dplSetPose
    Vec3f rootTranslation{0};
    std::vector<KitView> views;
    bool mayBeBlank = false;
    ToleranceBand band;
    std::vector<KitEarlierPose> earlier;  // oldest first; none: the pose has no time
    int64_t timeNs = 0;
};

/** Reads kit.json. Errors name the file. */
Result<std::vector<KitCase>> readKit(const std::filesystem::path& folder);

/** Draws every view into `pictures`/NAME.png, premultiplied RGBA, 8 bits. Returns the renderer's name. */
Result<std::string> drawKit(const std::filesystem::path& kit, const std::filesystem::path& pictures, doppel::Context& context);

/** The same with one of Doppel's renderers. Unsupported: this machine cannot run it. */
Result<std::string> drawKit(const std::filesystem::path& kit, const std::filesystem::path& pictures, DplRenderer renderer,
                            DplFill fill = DPL_FILL_AUTO);

}  // namespace dpl
