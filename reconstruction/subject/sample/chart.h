// SPDX-License-Identifier: Apache-2.0
// A test chart that a sample's shirt may carry: letters, bars and a check, from what every picture shows down to what none does. Private to
// reconstruction/subject/sample.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "reconstruction/subject/sample/scan_plan.h"

namespace dpl {

/** Upright bars in a field of kBarFieldM, as wide as the gaps between them; the left edge of the field is that of a bar. */
struct BarField {
    Vec2f centre{0};  // metres to the left of and above the chart's centre
    float barM = 0;
};

constexpr Vec2f kBarFieldM{0.030f, 0.015f};
constexpr std::array<BarField, 6> kBarFields{{{{-0.045f, -0.020f}, 0.0030f},
                                              {{0, -0.020f}, 0.0020f},
                                              {{0.045f, -0.020f}, 0.0015f},
                                              {{-0.045f, -0.042f}, 0.0010f},
                                              {{0, -0.042f}, 0.0008f},
                                              {{0.045f, -0.042f}, 0.0006f}}};

/** What a chart covers of the shirt at a place, 0 to 1. */
struct ChartInk {
    float panel = 0, ink = 0;
};

/** `at`: metres to the left of and above the chart's centre. Edges are one footprint wide; what is finer fades to its mean. */
ChartInk chartInk(const Vec2f& at, float footprintM);

/** The chart's centre on the shirt, canonical. */
constexpr Vec2f kChartCentre{0, 1.225f};

/** The bars of one width in a picture. */
struct BarsSeen {
    double barMm = 0;
    std::vector<Vec2d> topPx, bottomPx;  // along the upper and the lower edge of the field, evenly from its left to its right
};

/** Where a picture shows the bars of posed vertices; empty where a field lies behind or beside the camera. */
std::vector<BarsSeen> seeBars(const Subject& subject, const std::vector<Vec3d>& vertices, const Camerad& camera);

}  // namespace dpl
