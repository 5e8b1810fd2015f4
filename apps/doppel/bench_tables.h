// SPDX-License-Identifier: Apache-2.0
// What `doppel bench` prints of everybody who raced: frames, passes, memory, and the same as JSON lines.
#pragma once

#include "apps/doppel/bench_contestants.h"
#include "reconstruction/report/svg_plot.h"

namespace dpl {

std::string decibelText(double db);
/** For JSON and plots, which know no infinity. */
double finiteDb(double db);

/** A row a contestant, or several a case, under a header. */
struct BenchText {
    bool compared = true;  // with the referee
    uint32_t splatCount = 0;
    std::string frames, memory, json;

    /** samples: a pixel of the case, 1 or 4 (the plain frame takes 1). */
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
/** The model of docs/model.md for one case: the plain frame against today's by quads and by tiles, where those raced. Empty for general
 * splats. */
std::string modelOf(const BenchCase& test, const std::vector<Contestant>& list, const BenchSubject& subject, bool corrected,
                    const ModelMachine& machine);

/** To the table of its device, a new one if there is none; renderers without passes have none. */
void addPasses(std::vector<PassTable>& tables, const Contestant& contestant, const BenchCase& test);

/** A colour a renderer, a point a case. */
void addPoint(std::vector<PlotSeries>& plot, const Contestant& contestant, const BenchCase& test);

}  // namespace dpl
