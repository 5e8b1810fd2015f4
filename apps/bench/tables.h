// SPDX-License-Identifier: Apache-2.0
// The tables that every bench prints (frames, passes, memory), and the same figures as JSON lines.
#pragma once

#include "apps/bench/contestants.h"
#include "reconstruction/judging/report/svg_plot.h"

namespace dpl {

std::string decibelText(double db);
/** Replaces the infinite PSNR of equal pictures by 999, because JSON and plots cannot hold infinity. */
double finiteDb(double db);

/** Tables with one row per contestant and case. */
struct BenchText {
    bool compared = true;  // pictures were compared with the referee
    uint32_t splatCount = 0;
    std::string frames, memory, json;

    /** samples: samples per pixel, 1 or 4. The frozen baseline always takes 1. */
    void add(const BenchCase& test, const Contestant& contestant, uint32_t samples);
    std::string framesTable() const;
    std::string memoryTable() const;
};

/** Pass times of one device, median / 95th percentile in milliseconds: one row per pass, one column per case. */
struct PassTable {
    std::string device;
    std::string cases;
    size_t caseCount = 0;
    std::vector<std::string> labels, rows;

    void add(const Contestant& contestant, const BenchCase& test);
    std::string text() const;
};
/** Adds the contestant to its device's table and creates that table for a new device. Renderers without passes have no table. */
void addPasses(std::vector<PassTable>& tables, const Contestant& contestant, const BenchCase& test);

/** Adds one point: each renderer has its own colour, each case its own point. */
void addPoint(std::vector<PlotSeries>& plot, const Contestant& contestant, const BenchCase& test);

}  // namespace dpl
