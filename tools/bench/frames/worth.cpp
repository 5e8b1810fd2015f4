// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/frames/worth.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "apps/bench/json_row.h"
#include "apps/bench/tables.h"
#include "sdk/core/percentile.h"

namespace dpl {
namespace {

using PassFilter = bool (*)(std::string_view label);

/** GPU time of the passes that the filter accepts, in milliseconds for each round. */
std::vector<double> passMs(const Contestant& c, PassFilter takes) {
    std::vector<double> sums;
    for (const PassSamples& pass : c.passes) {
        if (!takes(pass.label)) continue;
        sums.resize(std::max(sums.size(), pass.milliseconds.size()));
        for (size_t k = 0; k < pass.milliseconds.size(); ++k) sums[k] += pass.milliseconds[k];
    }
    return sums;
}

bool beforePixels(std::string_view label) {
    return !label.starts_with("draw") && label != "tiles.fill" && label != "tiles.search" && label != "counts" && label != "readback";
}
/** From records or codes to coloured splats on the screen. Today's frame and the plain one split this work into different passes. */
bool projection(std::string_view label) {
    return label.starts_with("chunks") || label.starts_with("splat.");
}

double frameMs(const Contestant& c) {
    return percentile(c.milliseconds, 0.5);
}

const Contestant* findOption(const std::vector<Contestant>& list, std::string_view option) {
    const auto found = std::find_if(list.begin(), list.end(), [&](const Contestant& c) { return c.option == option; });
    return found == list.end() ? nullptr : &*found;
}

/** The fastest of today's ways to fill pixels on the GPU. */
const Contestant* fastestFill(const std::vector<Contestant>& list) {
    const Contestant* best = nullptr;
    for (const Contestant& c : list)
        if (!c.frozen && c.option != "software" && (!best || frameMs(c) < frameMs(*best))) best = &c;
    return best;
}

/** Ratio off / on of each round. Both times of a round are taken in turn, so that other work on the machine slows both. */
std::vector<double> ratiosOf(const std::vector<double>& off, const std::vector<double>& on) {
    std::vector<double> ratios;
    for (size_t k = 0; k < std::min(off.size(), on.size()); ++k)
        if (off[k] > 0 && on[k] > 0) ratios.push_back(off[k] / on[k]);
    return ratios;
}

/** Two cells: medians of both, and the median and quartiles of their ratios. */
std::string arrow(const std::vector<double>& off, const std::vector<double>& on) {
    const std::vector<double> ratios = ratiosOf(off, on);
    if (ratios.empty()) return "– | –";
    char text[160];
    std::snprintf(text, sizeof text, "%.2f → %.2f | %.2f × (%.2f – %.2f)", percentile(off, 0.5), percentile(on, 0.5),
                  percentile(ratios, 0.5), percentile(ratios, 0.25), percentile(ratios, 0.75));
    return text;
}

std::string frameWorth(const BenchCase& test, const std::string& what, const Contestant& off, const Contestant& on, bool compared) {
    const std::string error =
        compared ? formatText("{} → {} | {} → {}", decibelText(off.error.coveredPsnrDb()), decibelText(on.error.coveredPsnrDb()),
                              std::round(off.error.maxLevels * 10) / 10, std::round(on.error.maxLevels * 10) / 10)
                 : "– | –";
    return formatText("| {} | {} | {} → {} | {} | {} | {} |\n", test.name, what, off.stats.splatsDrawn, on.stats.splatsDrawn,
                      arrow(off.milliseconds, on.milliseconds), arrow(passMs(off, beforePixels), passMs(on, beforePixels)), error);
}

std::string passWorth(const BenchCase& test, const char* what, const char* where, const std::vector<double>& off,
                      const std::vector<double>& on) {
    return formatText("| {} | {} | {} | {} |\n", test.name, what, where, arrow(off, on));
}

void addRatios(JsonRow& row, const std::string& of, const std::vector<double>& off, const std::vector<double>& on) {
    const std::vector<double> ratios = ratiosOf(off, on);
    if (ratios.empty()) return;
    row.add(of + "_off_ms", percentile(off, 0.5)).add(of + "_on_ms", percentile(on, 0.5)).add(of + "_worth", percentile(ratios, 0.5));
    row.add(of + "_worth_p25", percentile(ratios, 0.25)).add(of + "_worth_p75", percentile(ratios, 0.75));
}

std::string jsonOf(const BenchCase& test, const Contestant& off, const Contestant& on) {
    JsonRow row;
    row.add("case", test.name).add("off", off.option).add("on", on.option).add("device", on.name);
    row.add("drawn_off", off.stats.splatsDrawn).add("drawn_on", on.stats.splatsDrawn);
    addRatios(row, "frame", off.milliseconds, on.milliseconds);
    addRatios(row, "before_pixels", passMs(off, beforePixels), passMs(on, beforePixels));
    addRatios(row, "projection", passMs(off, projection), passMs(on, projection));
    return row.line();
}

}  // namespace

void BenchWorth::add(const BenchCase& test, const std::vector<Contestant>& list) {
    const Contestant *plain = findOption(list, "vulkan-plain-float"), *plainTiles = findOption(list, "vulkan-plain-tiles"),
                     *quads = findOption(list, "vulkan-quads"), *tiles = findOption(list, "vulkan-tiles"), *best = fastestFill(list),
                     *software = findOption(list, "software");
    const auto frame = [&](const std::string& what, const Contestant* off, const Contestant* on) {
        if (!off || !on) return;
        frames += frameWorth(test, what, *off, *on, compared);
        json += jsonOf(test, *off, *on);
    };
    frame("plain float quads → quads", plain, quads);
    frame("plain float tiles → tiles", plainTiles, tiles);
    if (best && best != quads) frame("plain float quads → the faster fill, " + best->option, plain, best);
    frame("plain float quads → software", plain, software);

    if (!quads || quads->passes.empty()) return;
    const bool coded = quads->stats.splatsInView > 0;  // the current frame reads general splats as float records, too
    if (plain && coded)
        passes += passWorth(test, "codes decoded on demand", "chunks, projection and colour; off: plain float", passMs(*plain, projection),
                            passMs(*quads, projection));
}

std::string BenchWorth::text() const {
    std::string out;
    if (!frames.empty())
        out +=
            "\n| case | off → on | splats drawn: off → on | frame, ms: off → on | worth | before pixels are filled, GPU ms: off → on | "
            "worth | covered pixels: off → on | max error, levels: off → on |\n|---|---|---|---|---|---|---|---|---|\n" +
            frames;
    if (!passes.empty())
        out += "\n| case | what one optimisation is worth, quads | where | ms: off → on | worth |\n|---|---|---|---|---|\n" + passes;
    return out;
}

}  // namespace dpl
