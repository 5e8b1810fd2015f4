// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/sh_palette.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <queue>

#include "sdk/format/coded_splats.h"
#include "sdk/math/sh.h"

namespace dpl {
namespace {

constexpr double kMaxProducts = 1.5e10;  // multiply-adds of all Lloyd passes: some seconds on two cores
constexpr size_t kRowBlock = 1024;

/** The rows to cluster, with their weights and their current entries. */
struct Rows {
    uint32_t count = 0, width = 0;
    std::vector<float> values;  // count × width
    std::vector<double> weight;
    std::vector<uint32_t> entry;
    const float* row(size_t i) const { return values.data() + i * width; }
};

Rows rowsOf(const SplatData& s) {
    const uint32_t stride = shCoefficientCount(s.shDegree) * 3;
    Rows rows{s.count(), stride - 3, {}, {}, std::vector<uint32_t>(s.count(), 0)};
    rows.values.reserve(size_t(rows.count) * rows.width);
    for (uint32_t i = 0; i < rows.count; ++i) {
        rows.values.insert(rows.values.end(), s.sh.begin() + ptrdiff_t(size_t(i) * stride + 3),
                           s.sh.begin() + ptrdiff_t(size_t(i + 1) * stride));
        rows.weight.push_back(std::max(1e-12, double(s.opacity[i]) * s.scaleM[i].x * s.scaleM[i].y));
    }
    return rows;
}

/** The range [first, end) of `order`, whose rows share an entry. */
struct Cluster {
    uint32_t first = 0, end = 0, axis = 0;  // axis: dimension of the largest spread
    double squares = 0;                     // weighted sum of squared distances to the mean
    std::vector<double> mean;
};

Cluster clusterOf(const Rows& rows, const std::vector<uint32_t>& order, uint32_t first, uint32_t end) {
    Cluster c{first, end, 0, 0, std::vector<double>(rows.width, 0.0)};
    double total = 0;
    for (uint32_t k = first; k < end; ++k) {
        const double w = rows.weight[order[k]];
        total += w;
        for (uint32_t d = 0; d < rows.width; ++d) c.mean[d] += w * rows.row(order[k])[d];
    }
    for (double& m : c.mean) m /= total;
    std::vector<double> spread(rows.width, 0.0);
    for (uint32_t k = first; k < end; ++k)
        for (uint32_t d = 0; d < rows.width; ++d) {
            const double off = rows.row(order[k])[d] - c.mean[d];
            spread[d] += rows.weight[order[k]] * off * off;
        }
    c.axis = uint32_t(std::max_element(spread.begin(), spread.end()) - spread.begin());
    c.squares = std::accumulate(spread.begin(), spread.end(), 0.0);
    return c;
}

/** Splits the cluster with the largest error until there are maxEntries or the total error is at most maxSquares. Sets rows.entry and
 *  returns the entries. */
std::vector<float> splitUp(Rows& rows, uint32_t maxEntries, double maxSquares) {
    std::vector<uint32_t> order(rows.count);
    std::iota(order.begin(), order.end(), 0u);
    std::vector<Cluster> clusters = {clusterOf(rows, order, 0, rows.count)};
    const auto smaller = [&](uint32_t a, uint32_t b) {
        return clusters[a].squares != clusters[b].squares ? clusters[a].squares < clusters[b].squares : a > b;
    };
    std::priority_queue<uint32_t, std::vector<uint32_t>, decltype(smaller)> worst(smaller);
    worst.push(0);
    double squares = clusters[0].squares;
    while (clusters.size() < maxEntries && !worst.empty() && squares > maxSquares) {
        const uint32_t id = worst.top();
        worst.pop();
        const Cluster whole = clusters[id];
        if (!(whole.squares > 0)) break;
        const auto begin = order.begin() + whole.first, end = order.begin() + whole.end;
        const auto middle = std::stable_partition(begin, end, [&](uint32_t i) { return rows.row(i)[whole.axis] < whole.mean[whole.axis]; });
        if (middle == begin || middle == end) continue;  // its rows differ only by rounding
        const uint32_t cut = uint32_t(middle - order.begin());
        clusters[id] = clusterOf(rows, order, whole.first, cut);
        clusters.push_back(clusterOf(rows, order, cut, whole.end));
        squares += clusters[id].squares + clusters.back().squares - whole.squares;
        worst.push(id), worst.push(uint32_t(clusters.size() - 1));
    }
    std::vector<float> entries;
    for (uint32_t e = 0; e < clusters.size(); ++e) {
        for (uint32_t k = clusters[e].first; k < clusters[e].end; ++k) rows.entry[order[k]] = e;
        entries.insert(entries.end(), clusters[e].mean.begin(), clusters[e].mean.end());
    }
    return entries;
}

/** Assigns the nearest entry to every row; of equally near ones the first. */
void assignNearest(Rows& rows, const std::vector<float>& entries, Jobs& jobs) {
    const uint32_t width = rows.width, count = uint32_t(entries.size() / width);
    std::vector<float> columns(entries.size()),
        norms(count, 0.0f);  // columns: entries stored by dimension, so that the inner loop vectorises
    for (uint32_t e = 0; e < count; ++e)
        for (uint32_t d = 0; d < width; ++d)
            columns[size_t(d) * count + e] = entries[size_t(e) * width + d],
                                        norms[e] += entries[size_t(e) * width + d] * entries[size_t(e) * width + d] / 2;
    jobs.forRange(rows.count, kRowBlock, [&](size_t begin, size_t end, uint32_t) {
        std::vector<float> far(count);
        for (size_t i = begin; i < end; ++i) {
            std::copy(norms.begin(), norms.end(), far.begin());
            for (uint32_t d = 0; d < width; ++d) {
                const float x = rows.row(i)[d];
                const float* column = columns.data() + size_t(d) * count;
                for (uint32_t e = 0; e < count; ++e) far[e] -= x * column[e];  // ‖entry − row‖²/2 up to a constant
            }
            rows.entry[i] = uint32_t(std::min_element(far.begin(), far.end()) - far.begin());
        }
    });
}

/** Moves each entry to the mean of its rows. An entry without rows stays. Sums run in row order, so the result is reproducible. */
void moveToMeans(const Rows& rows, std::vector<float>& entries) {
    std::vector<double> sums(entries.size(), 0.0), weights(entries.size() / rows.width, 0.0);
    for (uint32_t i = 0; i < rows.count; ++i) {
        weights[rows.entry[i]] += rows.weight[i];
        for (uint32_t d = 0; d < rows.width; ++d) sums[size_t(rows.entry[i]) * rows.width + d] += rows.weight[i] * rows.row(i)[d];
    }
    for (size_t k = 0; k < entries.size(); ++k)
        if (const double w = weights[k / rows.width]; w > 0) entries[k] = float(sums[k] / w);
}

/** Rounds to the codec's values: multiples of 1/127 of the largest magnitude in each band. */
void snapToCodes(std::vector<float>& entries, uint32_t width, uint32_t degree) {
    for (uint32_t band = 1; band <= degree; ++band) {
        float range = 0;
        const uint32_t first = band * band * 3 - 3, end = (band + 1) * (band + 1) * 3 - 3;
        for (size_t k = 0; k < entries.size(); ++k)
            if (const size_t d = k % width; d >= first && d < end) range = std::max(range, std::abs(entries[k]));
        if (!(range > 0)) continue;
        for (size_t k = 0; k < entries.size(); ++k)
            if (const size_t d = k % width; d >= first && d < end)
                entries[k] = float(std::lround(127.0 * entries[k] / range) * double(range) / 127.0);
    }
}

}  // namespace

Result<ShPaletteReport> paletteSh(SplatData& splats, const ShPaletteSettings& settings, Jobs& jobs) {
    if (settings.maxEntries < 1 || settings.maxEntries > kMaxShPalette)
        return fail(Code::InvalidArgument, "an SH palette cannot have {} entries; use 1 to {}", settings.maxEntries, kMaxShPalette);
    ShPaletteReport report;
    if (splats.shDegree == 0 || splats.count() == 0) return report;
    Rows rows = rowsOf(splats);
    // The basis is orthonormal over the sphere, so the mean square over directions is Σ Δ² / 4π; divide by 3 for the mean over channels.
    const double levels2 = 255.0 * 255.0 / (4 * std::numbers::pi * 3);
    const double weights = std::accumulate(rows.weight.begin(), rows.weight.end(), 0.0);
    std::vector<float> entries = splitUp(rows, settings.maxEntries, settings.maxRmsLevels * settings.maxRmsLevels / levels2 * weights);
    const double products = double(rows.count) * double(entries.size());  // entries.size() counts numbers, not rows
    const uint32_t refinements = uint32_t(std::min(double(settings.refinements), std::floor(kMaxProducts / products)));
    for (uint32_t pass = 0; pass < refinements; ++pass) assignNearest(rows, entries, jobs), moveToMeans(rows, entries);
    snapToCodes(entries, rows.width, splats.shDegree);
    if (refinements > 0) assignNearest(rows, entries, jobs);

    const uint32_t stride = rows.width + 3;
    std::vector<bool> used(entries.size() / rows.width, false);
    double squares = 0;
    for (uint32_t i = 0; i < rows.count; ++i) {
        const float* entry = entries.data() + size_t(rows.entry[i]) * rows.width;
        double off2 = 0;
        for (uint32_t d = 0; d < rows.width; ++d) off2 += (double(entry[d]) - rows.row(i)[d]) * (double(entry[d]) - rows.row(i)[d]);
        squares += rows.weight[i] * off2;
        report.worstLevels = std::max(report.worstLevels, std::sqrt(off2 * levels2));
        std::copy(entry, entry + rows.width, splats.sh.begin() + ptrdiff_t(size_t(i) * stride + 3));
        used[rows.entry[i]] = true;
    }
    report.rmsLevels = std::sqrt(squares / weights * levels2);
    report.entries = uint32_t(std::count(used.begin(), used.end(), true));
    return report;
}

}  // namespace dpl
