// SPDX-License-Identifier: Apache-2.0
// Writes and reads the conformance kit as a folder, and scores a renderer's pictures against it.
//
//   kit.json           cases: avatar file, pose, cameras, tolerance band
//   NAME.glb           the avatars
//   reference/*.png    double-precision pictures, premultiplied RGBA, 16 bits
#pragma once

#include <doppel/doppel.h>

#include <filesystem>
#include <string>
#include <vector>

#include "apps/reference/reference_file.h"
#include "sdk/core/result.h"
#include "tests/conformance/cases.h"

namespace dpl {

/** One picture that a renderer must draw. */
struct KitView {
    std::string picture;  // file name: NAME.png, or NAME.left.png and NAME.right.png
    Cameraf camera;
};

struct KitCase {
    std::string name, about, avatarFile;
    std::vector<float> rotations;  // one xyzw quaternion per joint, as in dplSetPose
    Vec3f rootTranslation{0};
    std::vector<KitView> views;
    bool mayBeBlank = false;
    ToleranceBand band;
};

/** Writes the kit. The referee draws the reference pictures from the bytes of the avatar files. Each file is written atomically, kit.json
 *  last. */
Status writeKit(const std::filesystem::path& folder);

/** Reads kit.json. Errors name the file. */
Result<std::vector<KitCase>> readKit(const std::filesystem::path& folder);

/** Draws every view with one of Doppel's renderers into `pictures`/NAME.png, premultiplied RGBA, 8 bits. Returns the renderer's name.
 *  Unsupported: this machine cannot run the renderer. */
Result<std::string> drawKit(const std::filesystem::path& kit, const std::filesystem::path& pictures, DplRenderer renderer,
                            DplFill fill = DPL_FILL_AUTO);

struct CaseScore {
    std::string name;
    bool passed = false;
    std::string trouble;  // why it failed; empty when passed
    PictureError error;   // over all views
    double coverage = 0;  // share of the reference's pixels with alpha above 1/255
};

/** Compares pictures (PNG, premultiplied RGBA, 8 or 16 bits) with the kit's references. A missing or wrong picture fails its case, not the
 *  call. `sheet`, unless empty, receives a PNG with one row per view: reference, picture and eight times their difference. */
Result<std::vector<CaseScore>> scoreKit(const std::filesystem::path& kit, const std::filesystem::path& pictures,
                                        const std::filesystem::path& sheet = {});

/** A Markdown table, one row per case. */
std::string scoreTable(const std::vector<CaseScore>& scores);

}  // namespace dpl
