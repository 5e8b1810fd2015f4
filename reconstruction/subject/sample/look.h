// SPDX-License-Identifier: Apache-2.0
// Colours of the procedural subject: the albedo of a surface point is a function of its canonical position (at rest, before morphs).
#pragma once

#include <cstdint>
#include <string>

#include "sdk/math/types.h"

namespace dpl {

/** The appearance chosen by a seed. Colours are linear RGB albedo. */
struct Look {
    uint64_t seed = 0;
    Vec3f skin{0.55f, 0.36f, 0.27f}, lips{0.50f, 0.22f, 0.20f}, iris{0.12f, 0.20f, 0.25f}, hair{0.05f, 0.03f, 0.02f};
    float stubble = 0.3f;
    Vec3f shirt{0.05f, 0.12f, 0.25f}, shirtStripe{0.6f, 0.6f, 0.6f}, logoInk{0.8f, 0.75f, 0.6f}, logoAccent{0.75f, 0.15f, 0.08f};
    int shirtPattern = 0;  // 0 stripes, 1 check, 2 melange
    Vec3f shorts{0.25f, 0.22f, 0.15f}, shoes{0.6f, 0.6f, 0.6f}, shoeAccent{0.05f, 0.1f, 0.3f};
    float shirtHemY = 0.835f, sleeveM = 0.175f, bottomHemY = 0.565f;
    bool chart = false;   // a test chart (chart.h) in place of the shirt's print
    bool dotted = false;  // the bottom is a skirt with printed dots, not shorts with seams
};

Look makeLook(uint64_t seed);

struct SurfaceColour {
    Vec3f albedo{0.5f};  // linear
    float sheen = 0;     // of cloth or skin at grazing angles, 0 to 1
    float gloss = 0;     // strength of a narrow highlight (eyes, lips, shoes)
};

/** Colour of a point. `label` is a SubjectLabel, `footprintM` the size of a sample on the surface. Patterns finer than the footprint fade
 * to their mean. */
SurfaceColour surfaceColour(const Look& look, uint8_t label, const Vec3f& canonical, float footprintM);

/** Ink coverage (0 to 1) of the shirt's print: x of the letters, y of the emblem. `at` is in metres to the left of and above the print's
 *  centre. Edges are one footprint wide. */
Vec2f logoInk(const Vec2f& at, float footprintM);

/** Ink coverage of the letters DOPPEL. `at`: metres to the left of and above their lower left corner. */
float wordInk(const Vec2f& at, float heightM, float footprintM);

/** Coverage by bars whose centres lie at multiples of `periodM`; finer ones fade to their mean. */
float bars(float x, float periodM, float widthM, float footprintM);

}  // namespace dpl
