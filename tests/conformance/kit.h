// SPDX-License-Identifier: Apache-2.0
// Writes the conformance kit as a folder, and scores a renderer's pictures against it.
//
//   kit.json           cases: avatar file, pose, cameras, tolerance band
//   NAME.glb           the avatars
//   reference/*.png    double-precision pictures, premultiplied RGBA, 16 bits
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "apps/reference/reference_file.h"
#include "tests/conformance/kit_draw.h"

namespace dpl {

/** Writes the kit. The referee draws the reference pictures from the bytes of the avatar files. Each file is written atomically, kit.json
 *  last. */
Status writeKit(const std::filesystem::path& folder);

struct CaseScore {
    std::string name;
    bool passed = false;
    std::string trouble;  // why it failed; empty when passed
    PictureError error;   // over all views
    double coverage = 0;  // share of the reference's pixels with alpha above 1/255
};

/** Other references than the kit's own, with one band for all cases. */
struct OtherReferences {
    std::filesystem::path folder;
    ToleranceBand band;
};

/** Compares pictures (PNG, premultiplied RGBA, 8 or 16 bits) with the kit's references, or with others. A missing or wrong picture fails
 * its case, not the call. `sheet`, unless empty, receives a PNG with one row per view: reference, picture and eight times their difference.
 */
Result<std::vector<CaseScore>> scoreKit(const std::filesystem::path& kit, const std::filesystem::path& pictures,
                                        const std::filesystem::path& sheet = {}, const OtherReferences* others = nullptr);

/** A Markdown table, one row per case. */
std::string scoreTable(const std::vector<CaseScore>& scores);

}  // namespace dpl
