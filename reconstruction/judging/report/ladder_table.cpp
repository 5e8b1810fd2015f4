// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/report/ladder_table.h"

#include <nlohmann/json.hpp>

#include "reconstruction/judging/report/html_parts.h"
#include "reconstruction/judging/report/svg_plot.h"

namespace dpl {
namespace {

/** "18.42", or with the distance "18.42 (31 mm)"; a dash when the rung does not apply. */
std::string cellText(const LadderCell& cell, const char* dash) {
    if (cell.frames == 0) return dash;
    return decimals(cell.maskedPsnrDb, 2) + (cell.surfaceMm ? " (" + decimals(*cell.surfaceMm, 0) + " mm)" : "");
}

/** "31.2 of 40.1 (0.78)": with pose correctives, without, and the ratio. */
std::string ratioText(double correctedMm, double plainMm) {
    return decimals(correctedMm, 1) + " of " + decimals(plainMm, 1) + (plainMm > 0 ? " (" + decimals(correctedMm / plainMm, 2) + ")" : "");
}

std::string cellText(const GarmentCell& cell, const char* dash) {
    return cell.frames == 0 ? dash : ratioText(cell.correctedMm, cell.plainMm);
}

/** The distances of points of a row of garments. */
struct PointCell {
    GarmentCell cell;
};

std::string cellText(const PointCell& point, const char* dash) {
    return point.cell.frames == 0 ? dash : ratioText(point.cell.pointCorrectedMm, point.cell.pointPlainMm);
}

std::vector<PointCell> pointsOf(const GarmentRow& row) {
    std::vector<PointCell> points;
    for (const GarmentCell& cell : row.cells) points.push_back({cell});
    return points;
}

std::string rowName(const GarmentRow& row) {
    return row.garment + ", " + (row.poses == GarmentPoses::True ? "true poses" : "poses fitted to the pictures");
}

std::string heading(const LadderGroup& group) {
    return std::string(shortKindName(group.kind)) + " " + splitName(group.split) + " (" + std::to_string(group.frames) + ")";
}

std::string padded(const std::string& text, size_t width) {
    return text + std::string(text.size() < width ? width - text.size() : 0, ' ');
}

}  // namespace

std::string ladderText(const Ladder& ladder) {
    constexpr size_t kFirst = 74, kColumn = 22;
    std::string text = padded("masked PSNR, dB (mean distance to the true surface)", kFirst);
    for (const LadderGroup& group : ladder.groups)
        if (group.frames > 0) text += padded(heading(group), kColumn);
    const auto addCells = [&](const auto& cells) {
        for (size_t g = 0; g < ladder.groups.size(); ++g)
            if (ladder.groups[g].frames > 0) text += padded(cellText(cells[g], "-"), kColumn);
    };
    for (const LadderRung& rung : ladder.rungs) {
        text += "\n" + padded(rung.what, kFirst);
        addCells(rung.cells);
    }
    if (ladder.garments.empty()) return text;
    text += "\ngarments: distance from the truth, mm, of that under plain LBS (ratio)";
    for (const GarmentRow& row : ladder.garments) {
        text += "\n" + padded(rowName(row), kFirst);
        addCells(row.cells);
        text += "\n" + padded("  its points", kFirst);
        addCells(pointsOf(row));
    }
    return text;
}

std::string ladderHtml(const Ladder& ladder) {
    std::string head;
    for (const LadderGroup& group : ladder.groups)
        if (group.frames > 0) head += "<th>" + escapeHtml(heading(group)) + "</th>";
    const auto addRow = [&](std::string& html, const std::string& name, const auto& cells) {
        html += "<tr><td>" + escapeHtml(name) + "</td>";
        for (size_t g = 0; g < ladder.groups.size(); ++g)
            if (ladder.groups[g].frames > 0) html += "<td>" + cellText(cells[g], "–") + "</td>";
        html += "</tr>";
    };
    std::string html =
        "<h2>The ladder: what remains when the truth replaces a stage</h2><p class=soft>Masked PSNR in dB, and the mean distance of the "
        "avatar's vertices from where the true surface would carry them. Frames whose true surface is known; their number stands in "
        "brackets.</p>" +
        std::string(kTableBegin) + "<tr><th>rung</th>" + head + "</tr>";
    for (const LadderRung& rung : ladder.rungs) addRow(html, rung.what, rung.cells);
    html += kTableEnd;
    if (ladder.garments.empty()) return html;
    html +=
        "<p class=soft>Mean distance between each garment and the true one, both ways, in mm, of that of the same avatar without pose "
        "correctives; in brackets the ratio. Nearest distances do not see a garment slide along itself; those of points, each from the "
        "place of the true garment on which it lies when the person stands still, do.</p>" +
        std::string(kTableBegin) + "<tr><th>garment</th>" + head + "</tr>";
    for (const GarmentRow& row : ladder.garments) {
        addRow(html, rowName(row), row.cells);
        addRow(html, rowName(row) + ", its points", pointsOf(row));
    }
    return html + kTableEnd;
}

nlohmann::ordered_json ladderJson(const Ladder& ladder) {
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (const LadderRung& rung : ladder.rungs) {
        nlohmann::ordered_json row = {{"rung", rung.key}, {"what", rung.what}};
        for (size_t g = 0; g < ladder.groups.size(); ++g) {
            const LadderCell& cell = rung.cells[g];
            if (cell.frames == 0) continue;
            auto& entry = row[shortKindName(ladder.groups[g].kind)][splitName(ladder.groups[g].split)];
            entry = {{"frames", cell.frames}, {"masked_psnr_db", cell.maskedPsnrDb}};
            if (cell.surfaceMm) entry["surface_mm"] = *cell.surfaceMm;
        }
        rows.push_back(std::move(row));
    }
    return rows;
}

nlohmann::ordered_json garmentsJson(const Ladder& ladder) {
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (const GarmentRow& garment : ladder.garments) {
        nlohmann::ordered_json row = {{"garment", garment.garment}, {"poses", garment.poses == GarmentPoses::True ? "true" : "fitted"}};
        for (size_t g = 0; g < ladder.groups.size(); ++g)
            if (const GarmentCell& cell = garment.cells[g]; cell.frames > 0)
                row[shortKindName(ladder.groups[g].kind)][splitName(ladder.groups[g].split)] = {
                    {"frames", cell.frames},
                    {"corrected_mm", cell.correctedMm},
                    {"plain_mm", cell.plainMm},
                    {"point_corrected_mm", cell.pointCorrectedMm},
                    {"point_plain_mm", cell.pointPlainMm}};
        rows.push_back(std::move(row));
    }
    return rows;
}

}  // namespace dpl
