// SPDX-License-Identifier: Apache-2.0
#include "apps/doppel/bench_tables.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "apps/doppel/frame_model.h"
#include "sdk/core/percentile.h"

namespace dpl {
namespace {

constexpr double kPlyBytes = 62 * 4;  // a splat of degree 3 as 32-bit floats: what memory is compared with

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
                  double(c.stats.residentBytes) / (1 << 20), c.plain ? 1 : samples, static_cast<unsigned long long>(c.warmAllocations),
                  static_cast<unsigned long long>(c.warmWaits));
    return row;
}

std::string jsonLines(const BenchCase& test, const Contestant& c, uint32_t splatCount, uint32_t samples, bool compared) {
    char line[1000];
    std::string out;
    std::snprintf(line, sizeof line,
                  "{\"case\":\"%s\",\"views\":%u,\"width_px\":%u,\"height_px\":%u,\"device\":\"%s\",\"ms_p50\":%.3f,\"ms_p95\":%.3f,\"draw_"
                  "ms_p50\":%.3f,\"splats\":%u,\"splats_in_view\":%u,\"splats_facing\":%u,\"splats_drawn\":%u,\"chunks\":%u,\"chunks_"
                  "projected\":%u,\"components\":%u,\"components_in_view\":%u,\"resident_bytes\":%llu,\"avatar_bytes\":%llu,\"splat_"
                  "bytes\":%llu,\"bytes_decided\":%llu,\"bytes_decoded\":%llu,\"load_ms\":%.2f,\"tile_entries\":%u,\"tiles_overflowed\":%u,"
                  "\"samples\":%u,\"warm_allocations\":%llu,\"warm_waits\":%llu",
                  test.name, test.viewCount, test.widthPx, test.heightPx, c.name.c_str(), percentile(c.milliseconds, 0.5),
                  percentile(c.milliseconds, 0.95), percentile(c.drawMilliseconds, 0.5), splatCount, c.stats.splatsInView,
                  c.stats.splatsFacing, c.stats.splatsDrawn, c.stats.chunkCount, c.stats.chunksProjected, c.stats.componentCount,
                  c.stats.componentsInView, static_cast<unsigned long long>(c.stats.residentBytes),
                  static_cast<unsigned long long>(c.stats.avatarBytes), static_cast<unsigned long long>(c.stats.splatBytes),
                  static_cast<unsigned long long>(c.stats.bytesDecided), static_cast<unsigned long long>(c.stats.bytesDecoded),
                  c.loadMilliseconds, c.stats.tileEntries, c.stats.tilesOverflowed, c.plain ? 1 : samples,
                  static_cast<unsigned long long>(c.warmAllocations), static_cast<unsigned long long>(c.warmWaits));
    out += line;
    if (compared) {
        std::snprintf(line, sizeof line, ",\"psnr_db\":%.2f,\"covered_psnr_db\":%.2f,\"max_error_levels\":%.2f,\"covered_flip\":%.6f",
                      finiteDb(c.error.psnrDb()), finiteDb(c.error.coveredPsnrDb()), c.error.maxLevels, c.flip);
        out += line;
    }
    out += "}\n";
    for (const PassSamples& pass : c.passes) {
        std::snprintf(line, sizeof line,
                      "{\"case\":\"%s\",\"views\":%u,\"device\":\"%s\",\"pass\":\"%s\",\"gpu_ms_p50\":%.4f,\"gpu_ms_p95\":%.4f}\n",
                      test.name, test.viewCount, c.name.c_str(), pass.label.c_str(), percentile(pass.milliseconds, 0.5),
                      percentile(pass.milliseconds, 0.95));
        out += line;
    }
    return out;
}

/** What stays in memory, what a frame adds, what it reads of the splats, and how long loading took. */
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

std::string modelOf(const BenchCase& test, const std::vector<Contestant>& list, const BenchSubject& subject, bool corrected,
                    const ModelMachine& machine) {
    std::string rows;
    if (subject.info.jointCount == 0) return rows;
    FrameWork sizes{.vertices = subject.info.vertexCount,
                    .triangles = subject.info.triangleCount,
                    .splats = subject.info.splatCount,
                    .shDegree = subject.info.shDegree,
                    .corrected = corrected,
                    .views = test.viewCount,
                    .pixels = uint64_t(test.widthPx) * test.heightPx * test.viewCount};
    for (const char* option : {"vulkan-quads", "vulkan-tiles"})
        for (const Contestant& c : list) {
            if (c.option != option || c.stats.splatsDrawn == 0) continue;
            FrameWork work = sizes;
            work.trianglesFacing = c.stats.trianglesFacing, work.groups = c.stats.chunkCount, work.liveGroups = c.stats.chunksProjected,
            work.splatsFacing = c.stats.splatsFacing, work.splatsDrawn = c.stats.splatsDrawn;
            work.bytesDecided = c.stats.bytesDecided, work.bytesDecoded = c.stats.bytesDecoded;
            work.tileEntries = c.stats.tilesOverflowed ? 0 : c.stats.tileEntries;
            rows += modelRows(formatText("{}, {}", test.name, option), modelPlainFloat(work), modelToday(work), machine);
        }
    return rows;
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
