// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "reconstruction/judging/report/compare.h"
#include "reconstruction/judging/report/first_screen.h"
#include "reconstruction/judging/report/html_parts.h"
#include "reconstruction/judging/report/plain_words.h"
#include "reconstruction/judging/report/report.h"
#include "reconstruction/output/page/live_page.h"

namespace dpl {
namespace {

std::string fixed(double value, int digits) {
    return std::isfinite(value) ? decimals(value, digits) : "–";
}

std::string scoreRow(const std::string& name, const FrameScore& s) {
    return "<tr><td>" + escapeHtml(name) + "</td><td>" + fixed(s.maskedPsnrDb, 2) + "</td><td>" + fixed(s.maskedSsim, 4) + "</td><td>" +
           fixed(s.alphaIou, 4) + "</td><td>" + fixed(s.unionPsnrDb, 2) + "</td><td>" + fixed(s.unionSsim, 4) + "</td><td>" +
           fixed(100 * s.uncovered, 2) + "</td><td>" + fixed(100 * s.drawnOutside, 2) + "</td><td>" + fixed(s.lonePx, 1) + "</td><td>" +
           fixed(s.fullPsnrDb, 2) + "</td><td>" + fixed(s.fullSsim, 4) + "</td></tr>";
}

/** Two cells: the bar, and whether it is met; empty cells without a bar. */
std::string barCells(const ReportFigure& f) {
    if (!f.bar) return "<td></td><td></td>";
    return std::string("<td>") + (f.bar->atLeast ? "≥ " : "≤ ") + fixed(f.bar->value, f.bar->value == std::round(f.bar->value) ? 0 : 3) +
           (meetsBar(f) ? "</td><td class=met>met</td>" : "</td><td class=missed>missed</td>");
}

void addScores(std::string& html, const ReportData& data) {
    for (const FrameKind kind : {FrameKind::StaticFull, FrameKind::Dynamic}) {
        const auto fitted = meanScore(data.frames, kind, &HeldOutFrame::withPoseFit);
        if (!fitted) continue;
        size_t count = 0;
        for (const HeldOutFrame& frame : data.frames) count += frame.kind == kind;
        html +=
            "<h3>Held-out " + std::string(shortKindName(kind)) + " frames (" + std::to_string(count) + ")</h3><div class=big><div><b>" +
            fixed(fitted->maskedPsnrDb, 2) + " dB</b>masked PSNR</div><div><b>" + fixed(fitted->alphaIou, 4) +
            "</b>alpha IoU</div><div><b>" + fixed(fitted->maskedSsim, 4) + "</b>masked SSIM</div></div>" + kTableBegin +
            "<tr><th>mean of</th><th>masked PSNR dB</th><th>masked SSIM</th><th>alpha IoU</th><th>union PSNR dB</th><th>union "
            "SSIM</th><th>uncovered %</th><th>drawn outside %</th><th>lone px</th><th>full-frame PSNR dB</th><th>full-frame SSIM</th></tr>";
        html += scoreRow("avatar, with test-time pose fit", *fitted);
        html += scoreRow("avatar, without", *meanScore(data.frames, kind, &HeldOutFrame::withoutPoseFit));
        html += scoreRow("floor: one flat colour per label, true mask", *meanScore(data.frames, kind, &HeldOutFrame::labelFloor));
        html += scoreRow("floor: posed mesh, fitted vertex colours", *meanScore(data.frames, kind, &HeldOutFrame::meshFloor));
        html += kTableEnd +
                std::string(
                    "<p class=soft>Masked: inside the true mask, the render's own alpha over white, black and grey, worst of the three. "
                    "Union: the same over the mask and what is drawn outside of it. Uncovered and drawn outside: pixels over those of "
                    "the mask. Lone: pixels of specks that stand free of the person, a frame. Full-frame: on white, "
                    "truth cut out with its mask; the person covers ") +
                fixed(fitted->coverage * 100, 1) + " % of the frame, so white flatters these figures.</p>";
    }
}

bool hasPictures(const ReportData& data) {
    return std::ranges::any_of(data.frames, [](const HeldOutFrame& frame) { return !frame.renderPng.empty(); });
}

void addPictures(std::string& html, const ReportData& data) {
    if (!hasPictures(data)) return;
    html +=
        "<h2>The avatar beside its pictures</h2><p class=soft>Left the picture, right the avatar. It was not made from these pictures; "
        "only "
        "its pose was fitted to each.</p><div class=\"pictures pairs\">";
    for (const HeldOutFrame& frame : data.frames)
        if (!frame.renderPng.empty())
            html += "<figure>" + pngImage(frame.truthPng, "picture") + pngImage(frame.renderPng, "avatar") + "</figure>";
    html += "</div>";
}

void addErrorMap(std::string& html, const ReportData& data) {
    if (data.errorMap.empty()) return;
    html +=
        "<h2>Where it differs</h2><p class=soft>All pictures above together, on the body: bright is close to them, dark is far from them, "
        "grey is in none of them.</p><div class=maps>" +
        pngImage(data.errorMap, "error map: front and back of the body") + "</div>";
}

void addDifferences(std::string& html, const ReportData& data) {
    if (!hasPictures(data)) return;
    html +=
        "<h2>What differs from the pictures</h2><p class=soft>Four times as strong, in the order of the pictures above.</p>"
        "<div class=\"pictures differences\">";
    for (const HeldOutFrame& frame : data.frames) {
        if (frame.renderPng.empty()) continue;
        html += "<figure>" + pngImage(frame.differencePng, "difference") + "<figcaption>" + escapeHtml(frame.name) + " <span class=soft>" +
                fixed(frame.withPoseFit.maskedPsnrDb, 2) + " dB · IoU " + fixed(frame.withPoseFit.alphaIou, 3) + " · uncovered " +
                fixed(100 * frame.withPoseFit.uncovered, 1) + " % · outside " + fixed(100 * frame.withPoseFit.drawnOutside, 1) +
                " %</span></figcaption></figure>";
    }
    html += "</div>";
}

void addMap(std::string& html, const FilmAgainSection& section) {
    const std::vector<MapRow>& rows = section.rows;
    if (rows.empty() && section.pictures.empty()) return;
    html += "<h2>Body map</h2><p class=soft>What the still pictures show of each place of the body. Bright is good.</p><div class=maps>";
    for (const std::vector<uint8_t>& png : section.pictures) html += pngImage(png, "body map");
    html += "</div>";
    if (rows.empty()) return;
    html += std::string(kTableBegin) +
            "<tr><th>place</th><th>mm a pixel</th><th>finest detail mm</th><th>blur px</th><th>pictures</th><th>not seen %</th></tr>";
    for (const MapRow& row : rows)
        html += "<tr><td>" + escapeHtml(row.place) + "</td><td>" + fixed(row.pixelMm, 2) + "</td><td>" + fixed(row.detailMm, 2) +
                "</td><td>" + fixed(row.blurPx, 1) + "</td><td>" + fixed(row.pictures, 0) + "</td><td>" + fixed(100 * row.unseenShare, 0) +
                "</td></tr>";
    html += kTableEnd;
}

void addFigures(std::string& html, const char* heading, const std::vector<ReportFigure>& figures) {
    if (figures.empty()) return;
    html +=
        "<h2>" + std::string(heading) + "</h2>" + kTableBegin + "<tr><th>what</th><th>value</th><th>unit</th><th>bar</th><th></th></tr>";
    std::string group;
    for (const ReportFigure& f : figures) {
        if (f.group != group) html += "<tr><td colspan=5><b>" + escapeHtml(group = f.group) + "</b></td></tr>";
        html += "<tr><td>" + escapeHtml(f.name) + "</td><td>" + fixed(f.value, std::abs(f.value) >= 1000 ? 0 : 3) + "</td><td class=text>" +
                escapeHtml(f.unit) + "</td>" + barCells(f) + "</tr>";
    }
    html += kTableEnd;
}

void addStages(std::string& html, const ReportData& data) {
    if (data.stages.empty()) return;
    double total = 0;
    for (const StageCost& s : data.stages) total += s.seconds;
    html +=
        "<h2>Time and memory</h2>" + std::string(kTableBegin) + "<tr><th>stage</th><th>seconds</th><th>peak memory MiB</th><th></th></tr>";
    for (const StageCost& s : data.stages)
        html += "<tr><td>" + escapeHtml(s.name) + (s.reused ? " <span class=soft>(earlier run)</span>" : "") + "</td><td>" +
                fixed(s.seconds, 1) + "</td><td>" + fixed(double(s.peakBytes) / (1 << 20), 0) +
                "</td><td class=text><span class=bar style=\"width:" + fixed(total > 0 ? s.seconds / total * 300 : 0, 0) +
                "px\"></span></td></tr>";
    html += "<tr><td><b>all</b></td><td><b>" + fixed(total, 1) + "</b></td><td></td><td></td></tr>" + kTableEnd;
}

void addEvidence(std::string& html, const ReportData& data) {
    if (data.evidence.empty()) return;
    html += "<h2>Evidence: what is in the file, and why</h2>" + std::string(kTableBegin) +
            "<tr><th>part</th><th>kept</th><th>gain "
            "dB</th><th>bytes</th><th>reason</th></tr>";
    for (const EvidenceData& e : data.evidence)
        html += "<tr><td>" + escapeHtml(e.part) + "</td><td>" + (e.kept ? "yes" : "no") + "</td><td>" +
                (e.gainDb != 0 ? fixed(e.gainDb, 2) : "–") + "</td><td>" + std::to_string(e.bytes) + "</td><td class=reason>" +
                escapeHtml(e.reason) + "</td></tr>";
    html += kTableEnd;
}

void addTraining(std::string& html, const ReportData& data) {
    if (data.lossCurves.empty() && data.psnrCurves.empty()) return;
    html += "<h2>Training</h2>";
    const auto addPlot = [&](const std::vector<PlotSeries>& curves, const PlotOptions& options) {
        if (!curves.empty()) html += "<div class=scroll>" + svgPlot(curves, options) + "</div>";
    };
    addPlot(data.lossCurves, {.title = "Loss", .xLabel = "step", .yLabel = "loss", .logY = true});
    addPlot(data.psnrCurves, {.title = "PSNR on training frames", .xLabel = "step", .yLabel = "dB"});
}

void addQuality(std::string& html, const ReportData& data) {
    html += "<h2>Quality on held-out frames</h2><p class=soft>";
    html += data.frames.empty() ? "No frame was held out, so nothing is scored here."
                                : "No held-out picture was used to make the avatar. Only the pose fit uses them: it moves the finished "
                                  "avatar to match each picture.";
    html += "</p>";
    for (const std::string& sentence : data.provenance) html += "<p><b>" + escapeHtml(sentence) + "</b></p>";
    addScores(html, data);
    addFigures(html, "Above the floors", floorFigures(data.frames));
}

/** What engineers and researchers look for. It is folded, because it says nothing to the person who filmed. */
void addDetails(std::string& html, const ReportData& data) {
    html += "<details class=engineers><summary>For engineers</summary><p class=soft>";
    for (const auto& [name, value] : data.facts) html += escapeHtml(name) + ": " + escapeHtml(value) + "<br>";
    html += "</p><p class=soft>" + escapeHtml(kWorthRule) + "</p>";
    addQuality(html, data);
    addDifferences(html, data);
    addMap(html, data.filmAgain);
    if (!data.verdict.empty()) html += "<h2>Scan check</h2><pre>" + escapeHtml(data.verdict) + "</pre>";
    addTraining(html, data);
    addFigures(html, "Registration and sizes", data.figures);
    addFigures(html, "Error waterfall: what each stage costs", data.waterfall);
    if (data.ladder) html += ladderHtml(*data.ladder);
    addStages(html, data);
    addEvidence(html, data);
    html += "</details>";
}

std::string pageHead(const std::string& title, const std::string& moreStyle = {}) {
    return "<!doctype html><html lang=en><meta charset=utf-8><meta name=viewport content=\"width=device-width,initial-scale=1\"><title>" +
           escapeHtml(title) + "</title><style>" + kPageStyle + moreStyle + "</style>";
}

}  // namespace

std::string unfinishedHtml(const std::string& title, const FilmAgainSection& filmAgain) {
    std::string html =
        pageHead(title) + "<h1>" + escapeHtml(title) +
        "</h1><p class=verdict>The avatar is not finished yet. If its run was stopped, nothing is lost: the same command goes "
        "on where it was, and this page then shows the avatar.</p>";
    addAdvice(html, filmAgain);
    return html + "</html>\n";
}

std::string reportHtml(const ReportData& data) {
    const bool alive = data.live && !data.portrait.png.empty();
    std::string html = pageHead(data.title, kCompareStyle + (alive ? data.live->module.style : ""));
    addTop(html, data);
    addAdvice(html, data.filmAgain);
    addClips(html, data.clips);
    addPictures(html, data);
    addErrorMap(html, data);
    if (const std::vector<std::string> parts = leftOut(data.evidence); !parts.empty()) {
        html += "<h2>What this avatar does not have</h2>";
        html += bulletList(parts);
    }
    addDetails(html, data);
    if (hasPictures(data)) html += std::string("<script>") + kCompareScript + "</script>";
    if (alive) html += liveParts(data.live->module, data.live->avatar);
    return html + "</html>\n";
}

}  // namespace dpl
