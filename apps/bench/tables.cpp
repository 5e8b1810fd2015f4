// SPDX-License-Identifier: Apache-2.0
#include "apps/bench/tables.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "apps/bench/json_row.h"
#include "sdk/core/percentile.h"

namespace dpl {
namespace {

constexpr double kPlyBytes = 62 * 4;  // one splat of SH degree 3 in a PLY of 32-bit floats; the memory table compares with it

std::string rounded(double value, double steps) {
    return formatText("{}", std::round(value * steps) / steps);
}

std::string frameRow(const BenchCase& test, const Contestant& c, uint32_t splatCount, uint32_t samples, bool compared) {
    char row[520];
    const double gpu = percentile(c.gpuMilliseconds, 0.5);
    const std::string tiers = c.stats.splatsInView > 0
                                  ? formatText("{} → {} → {} → ", splatCount, c.stats.splatsInView, c.stats.splatsFacing)
                                  : formatText("{} → ", splatCount);
    std::snprintf(row, sizeof row, "| %s | %s | %.2f | %.2f | %.2f | %s | %s | %s | %s | %s | %s%u | %s | %s | %.1f | %u | %llu, %llu |\n",
                  test.name, c.name.c_str(), percentile(c.milliseconds, 0.5), percentile(c.milliseconds, 0.95),
                  percentile(c.drawMilliseconds, 0.5), gpu > 0 ? rounded(gpu, 100).c_str() : "–",
                  compared ? decibelText(c.error.psnrDb()).c_str() : "–", compared ? decibelText(c.error.coveredPsnrDb()).c_str() : "–",
                  compared ? rounded(c.error.maxLevels, 10).c_str() : "–", compared ? rounded(c.flip, 1e5).c_str() : "–", tiers.c_str(),
                  c.stats.splatsDrawn,
                  c.stats.chunkCount > 0 ? formatText("{} of {}", c.stats.chunksProjected, c.stats.chunkCount).c_str() : "–",
                  c.stats.componentCount > 0 ? formatText("{} of {}", c.stats.componentsInView, c.stats.componentCount).c_str() : "–",
                  double(c.stats.residentBytes) / (1 << 20), c.frozen ? 1 : samples, static_cast<unsigned long long>(c.warmAllocations),
                  static_cast<unsigned long long>(c.warmWaits));
    return row;
}

std::string jsonLines(const BenchCase& test, const Contestant& c, uint32_t splatCount, uint32_t samples, bool compared) {
    JsonRow row;
    row.add("case", test.name).add("renderer", c.option).add("device", c.name);
    row.add("views", test.viewCount).add("width_px", test.widthPx).add("height_px", test.heightPx).add("samples", c.frozen ? 1u : samples);
    row.add("ms_p50", percentile(c.milliseconds, 0.5)).add("ms_p95", percentile(c.milliseconds, 0.95));
    row.add("draw_ms_p50", percentile(c.drawMilliseconds, 0.5)).add("gpu_ms_p50", percentile(c.gpuMilliseconds, 0.5));
    row.add("splats", splatCount).add("splats_in_view", c.stats.splatsInView).add("splats_facing", c.stats.splatsFacing);
    row.add("splats_drawn", c.stats.splatsDrawn).add("chunks", c.stats.chunkCount).add("chunks_projected", c.stats.chunksProjected);
    row.add("components", c.stats.componentCount).add("components_in_view", c.stats.componentsInView);
    row.add("tile_entries", c.stats.tileEntries).add("tiles_overflowed", c.stats.tilesOverflowed);
    row.add("resident_bytes", c.stats.residentBytes).add("avatar_bytes", c.stats.avatarBytes).add("splat_bytes", c.stats.splatBytes);
    row.add("bytes_decided", c.stats.bytesDecided).add("bytes_decoded", c.stats.bytesDecoded).add("load_ms", c.loadMilliseconds);
    row.add("warm_allocations", c.warmAllocations).add("warm_waits", c.warmWaits);
    if (compared) {
        row.add("psnr_db", finiteDb(c.error.psnrDb())).add("covered_psnr_db", finiteDb(c.error.coveredPsnrDb()));
        row.add("max_error_levels", c.error.maxLevels).add("covered_flip", c.flip);
    }
    std::string out = row.line();
    for (const PassSamples& pass : c.passes) {
        JsonRow line;
        line.add("case", test.name).add("views", test.viewCount).add("device", c.name).add("pass", pass.label);
        line.add("gpu_ms_p50", percentile(pass.milliseconds, 0.5)).add("gpu_ms_p95", percentile(pass.milliseconds, 0.95));
        out += line.line();
    }
    return out;
}

/** Bytes that stay in memory, bytes that a frame adds, bytes of splats that it reads, and the time of loading. */
std::string memoryRow(const BenchCase& test, const Contestant& c, uint32_t splatCount) {
    const double ply = kPlyBytes * std::max(1u, splatCount), n = std::max(1u, splatCount);
    const auto share = [&](uint64_t bytes) { return 100 * double(bytes) / ply; };
    const uint64_t working = c.stats.residentBytes - std::min(c.stats.residentBytes, c.stats.avatarBytes);
    char row[400];
    std::snprintf(row, sizeof row, "| %s | %s | %.1f | %.1f B, %.1f %% | %.2f MB, %.1f %% | %.1f MB, %.1f %% | %.2f | %.2f |\n", test.name,
                  c.name.c_str(), c.loadMilliseconds, double(c.stats.splatBytes) / n, share(c.stats.splatBytes),
                  double(c.stats.avatarBytes) / 1e6, share(c.stats.avatarBytes), double(working) / 1e6, share(working),
                  double(c.stats.bytesDecided) / n, double(c.stats.bytesDecoded) / n);
    return row;
}

}  // namespace

std::string decibelText(double db) {
    return std::isfinite(db) ? formatText("{} dB", std::round(db * 10) / 10) : "equal";
}
double finiteDb(double db) {
    return std::isfinite(db) ? db : 999;
}

void BenchText::add(const BenchCase& test, const Contestant& contestant, uint32_t samples) {
    frames += frameRow(test, contestant, splatCount, samples, compared);
    memory += memoryRow(test, contestant, splatCount);
    json += jsonLines(test, contestant, splatCount, samples, compared);
}

std::string BenchText::framesTable() const {
    return "| case | renderer | ms | p95 | dplDraw ms | GPU ms | PSNR | covered pixels | max error, levels | FLIP | splats → in view → "
           "facing → drawn | chunks projected | components in view | resident MiB | samples a pixel | warm frames: allocations, waits |\n"
           "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n" +
           frames;
}

std::string BenchText::memoryTable() const {
    return "\n| case | renderer | load ms | splats: bytes each, of PLY | avatar, of PLY | working set, of PLY | phase 1: bytes read a "
           "splat | phase 2 |\n|---|---|---|---|---|---|---|---|\n" +
           memory;
}

void PassTable::add(const Contestant& c, const BenchCase& test) {
    cases += formatText(" {} |", test.name), ++caseCount;
    for (const PassSamples& pass : c.passes) {
        size_t row = size_t(std::find(labels.begin(), labels.end(), pass.label) - labels.begin());
        if (row == labels.size()) labels.push_back(pass.label), rows.push_back("| " + pass.label + " |");
        char cell[80];
        std::snprintf(cell, sizeof cell, " %.3f / %.3f |", percentile(pass.milliseconds, 0.5), percentile(pass.milliseconds, 0.95));
        rows[row] += cell;
    }
}

std::string PassTable::text() const {
    std::string out = "\n| GPU ms, " + device + " |" + cases + "\n|---|";
    for (size_t k = 0; k < caseCount; ++k) out += "---|";
    out += "\n";
    for (const std::string& row : rows) out += row + "\n";
    return out;
}

void addPasses(std::vector<PassTable>& tables, const Contestant& c, const BenchCase& test) {
    if (c.passes.empty()) return;
    auto table = std::find_if(tables.begin(), tables.end(), [&](const PassTable& t) { return t.device == c.name; });
    if (table == tables.end()) table = tables.insert(table, {c.name, {}, 0, {}, {}});
    table->add(c, test);
}

void addPoint(std::vector<PlotSeries>& plot, const Contestant& c, const BenchCase& test) {
    auto points = std::find_if(plot.begin(), plot.end(), [&](const PlotSeries& s) { return s.name == c.name; });
    if (points == plot.end()) points = plot.insert(points, {c.name, {}, {}});
    points->x.push_back(percentile(c.milliseconds, 0.5)), points->y.push_back(finiteDb(c.error.coveredPsnrDb()));
    points->pointNames.push_back(std::string(test.name).substr(0, std::string_view(test.name).find(' ')));
}

}  // namespace dpl
