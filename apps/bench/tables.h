// SPDX-License-Identifier: Apache-2.0
// The tables that every bench prints of its contestants: frames, passes, memory; and the same figures as JSON lines.
#pragma once

#include "apps/bench/contestants.h"
#include "reconstruction/report/svg_plot.h"

namespace dpl {

std::string decibelText(double db);
/** Equal pictures have an infinite PSNR, which JSON and plots do not know: 999 instead. */
double finiteDb(double db);

/** One row for each contestant of each case. */
struct BenchText {
    bool compared = true;  // with the referee
    uint32_t splatCount = 0;
    std::string frames, memory, json;

    /** samples: of each pixel, 1 or 4; the frozen baseline takes 1 whatever this says. */
    void add(const BenchCase& test, const Contestant& contestant, uint32_t samples);
    std::string framesTable() const;
    std::string memoryTable() const;
};

/** One row a pass, one column a case that was run: median / 95th percentile. */
struct PassTable {
    std::string device;
    std::string cases;
    size_t caseCount = 0;
    std::vector<std::string> labels, rows;

    void add(const Contestant& contestant, const BenchCase& test);
    std::string text() const;
};
/** Adds the contestant to the table of its device, and makes that table for a new one. Renderers without passes have no table. */
void addPasses(std::vector<PassTable>& tables, const Contestant& contestant, const BenchCase& test);

/** A colour a renderer, a point a case. */
void addPoint(std::vector<PlotSeries>& plot, const Contestant& contestant, const BenchCase& test);

}  // namespace dpl
