// SPDX-License-Identifier: Apache-2.0
// The conformance kit as a folder, and the score of a renderer against it.
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

/** One picture that a renderer is asked for. */
struct KitView {
    std::string picture;  // file name: NAME.png, or NAME.left.png and NAME.right.png
    Cameraf camera;
};

struct KitCase {
    std::string name, about, avatarFile;
    std::vector<float> rotations;  // xyzw a joint, as in dplSetPose
    Vec3f rootTranslation{0};
    std::vector<KitView> views;
    bool mayBeBlank = false;
    ToleranceBand band;
};

/** Writes the kit; references are drawn by the referee from the bytes of the files. Files are renamed into place, kit.json last. */
Status writeKit(const std::filesystem::path& folder);

/** Errors name the file. */
Result<std::vector<KitCase>> readKit(const std::filesystem::path& folder);

/** Draws every view of the kit with one of our renderers: `pictures`/NAME.png, premultiplied RGBA, 8 bits. Returns the renderer's name. */
Result<std::string> drawKit(const std::filesystem::path& kit, const std::filesystem::path& pictures, DplRenderer renderer,
                            DplFill fill = DPL_FILL_AUTO);

struct CaseScore {
    std::string name;
    bool passed = false;
    std::string trouble;  // why not: what is missing or how far it is off; empty when passed
    PictureError error;   // over all views
    double coverage = 0;  // of the reference: share of pixels with alpha above 1/255
};

/** Compares pictures (PNG, premultiplied RGBA, 8 or 16 bits) with the kit's. A missing or wrong picture fails its case, not the call.
 *  `sheet`, unless empty: a PNG with reference, picture and eight times their difference, a row a view. */
Result<std::vector<CaseScore>> scoreKit(const std::filesystem::path& kit, const std::filesystem::path& pictures,
                                        const std::filesystem::path& sheet = {});

/** A Markdown table, one row a case. */
std::string scoreTable(const std::vector<CaseScore>& scores);

}  // namespace dpl
