// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <span>

#include "reconstruction/judging/report/report.h"

namespace dpl {
namespace {

constexpr const char* kStyle = R"(
:root{color-scheme:light dark;--fg:#1f2937;--soft:#6b7280;--line:#e5e7eb;--card:#f9fafb;--accent:#2563eb}
@media(prefers-color-scheme:dark){:root{--fg:#e5e7eb;--soft:#9ca3af;--line:#374151;--card:#1f2937;--accent:#60a5fa}body{background:#111827}}
body{font:15px/1.5 system-ui,sans-serif;color:var(--fg);max-width:1080px;margin:2rem auto;padding:0 1rem}
h1{margin-bottom:.2rem}h2{margin-top:2.2rem;border-bottom:1px solid var(--line);padding-bottom:.2rem}
table{border-collapse:collapse;margin:.8rem 0;font-variant-numeric:tabular-nums}
th,td{padding:.25rem .8rem;border-bottom:1px solid var(--line);text-align:right}th:first-child,td:first-child{text-align:left}
td.text{text-align:left}.soft{color:var(--soft)}pre{background:var(--card);padding:.8rem;overflow:auto}
.big{display:flex;gap:1rem;flex-wrap:wrap}.big div{background:var(--card);border-radius:.5rem;padding:.7rem 1.1rem}
.big b{display:block;font-size:1.7rem}.pictures{display:grid;grid-template-columns:repeat(auto-fill,minmax(320px,1fr));gap:1rem}
.pictures figure{margin:0;background:var(--card);border-radius:.5rem;padding:.5rem}.pictures img{width:32.6%;image-rendering:auto}
.maps{display:flex;flex-wrap:wrap;gap:1rem}.maps img{max-width:100%}
.plot{max-width:100%;height:auto}.plot text{font:11px system-ui;fill:var(--soft)}.plot text.title{font-size:13px;fill:var(--fg)}.plot .grid{stroke:var(--line)}
.bar{background:var(--accent);height:.8rem;display:inline-block;border-radius:2px}.met{color:#15803d}.missed{color:#b91c1c;font-weight:bold}
)";

std::string fixed(double value, int digits) {
    char text[48];
    std::snprintf(text, sizeof text, "%.*f", digits, value);
    return std::isfinite(value) ? text : "–";
}

std::string base64(std::span<const uint8_t> bytes) {
    static constexpr char kAlphabet[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    out.reserve((bytes.size() + 2) / 3 * 4);
    for (size_t i = 0; i < bytes.size(); i += 3) {
        uint32_t word = uint32_t(bytes[i]) << 16;
        if (i + 1 < bytes.size()) word |= uint32_t(bytes[i + 1]) << 8;
        if (i + 2 < bytes.size()) word |= bytes[i + 2];
        out += kAlphabet[word >> 18];
        out += kAlphabet[word >> 12 & 63];
        out += i + 1 < bytes.size() ? kAlphabet[word >> 6 & 63] : '=';
        out += i + 2 < bytes.size() ? kAlphabet[word & 63] : '=';
    }
    return out;
}

std::string picture(const std::vector<uint8_t>& png, const char* what) {
    if (png.empty()) return {};
    return "<img alt=\"" + std::string(what) + "\" title=\"" + what + "\" src=\"data:image/png;base64," + base64(png) + "\">";
}

std::string scoreRow(const std::string& name, const FrameScore& s) {
    return "<tr><td>" + escapeHtml(name) + "</td><td>" + fixed(s.maskedPsnrDb, 2) + "</td><td>" + fixed(s.maskedSsim, 4) + "</td><td>" +
           fixed(s.alphaIou, 4) + "</td><td>" + fixed(s.fullPsnrDb, 2) + "</td><td>" + fixed(s.fullSsim, 4) + "</td></tr>";
}

/** Two cells: the bar, and whether it is met; empty cells without a bar. */
std::string barCells(const ReportFigure& f) {
    if (!f.bar) return "<td></td><td></td>";
    return std::string("<td>") + (f.bar->atLeast ? "≥ " : "≤ ") + fixed(f.bar->value, f.bar->value == std::round(f.bar->value) ? 0 : 3) +
           (meetsBar(f) ? "</td><td class=met>met</td>" : "</td><td class=missed>missed</td>");
}

void addScores(std::string& html, const ReportData& data) {
    for (const char* kind : {"static", "dynamic"}) {
        const auto fitted = meanScore(data.frames, kind, &HeldOutFrame::withPoseFit);
        if (!fitted) continue;
        size_t count = 0;
        for (const HeldOutFrame& frame : data.frames) count += frame.kind == kind;
        html += "<h3>Held-out " + std::string(kind) + " frames (" + std::to_string(count) + ")</h3><div class=big><div><b>" +
                fixed(fitted->maskedPsnrDb, 2) + " dB</b>masked PSNR</div><div><b>" + fixed(fitted->alphaIou, 4) +
                "</b>alpha IoU</div><div><b>" + fixed(fitted->maskedSsim, 4) +
                "</b>masked SSIM</div></div><table><tr><th>mean of</th><th>masked PSNR dB</th><th>masked SSIM</th><th>alpha "
                "IoU</th><th>full-frame PSNR "
                "dB</th><th>full-frame SSIM</th></tr>";
        html += scoreRow("avatar, with test-time pose fit", *fitted);
        html += scoreRow("avatar, without", *meanScore(data.frames, kind, &HeldOutFrame::withoutPoseFit));
        html += scoreRow("floor: one flat colour per label, true mask", *meanScore(data.frames, kind, &HeldOutFrame::labelFloor));
        html += scoreRow("floor: posed mesh, fitted vertex colours", *meanScore(data.frames, kind, &HeldOutFrame::meshFloor));
        html +=
            "</table><p class=soft>Masked: inside the true mask, the render's own alpha over white, black and grey, worst of the three. "
            "Full-frame: on white, "
            "truth cut out with its mask; the person covers " +
            fixed(fitted->coverage * 100, 1) + " % of the frame, so white flatters these figures.</p>";
    }
}

void addPictures(std::string& html, const ReportData& data) {
    bool any = false;
    for (const HeldOutFrame& frame : data.frames) any |= !frame.renderPng.empty();
    if (!any) return;
    html +=
        "<h2>Pictures</h2><p class=soft>Truth, avatar (pose fitted), difference ×4. None of these frames was used to make the "
        "avatar. Its pose was fitted to each.</p><div class=pictures>";
    for (const HeldOutFrame& frame : data.frames) {
        if (frame.renderPng.empty()) continue;
        html += "<figure>" + picture(frame.truthPng, "truth") + picture(frame.renderPng, "avatar") +
                picture(frame.differencePng, "difference") + "<figcaption>" + escapeHtml(frame.name) + " · " +
                fixed(frame.withPoseFit.maskedPsnrDb, 2) + " dB · IoU " + fixed(frame.withPoseFit.alphaIou, 3) + "</figcaption></figure>";
    }
    html += "</div>";
}

/** Begins the page, because it is what the reader can change. */
void addFilmAgain(std::string& html, const FilmAgainSection& section) {
    if (section.advice.empty()) return;
    html += "<h2>What to film again</h2><pre>" + escapeHtml(section.advice) + "</pre>";
    html +=
        "<p class=soft>The map shows what the still training pictures show of each place of the body. Bright is good.</p><div class=maps>";
    for (const std::vector<uint8_t>& png : section.pictures) html += picture(png, "body map");
    html +=
        "</div><table><tr><th>place</th><th>mm a pixel</th><th>finest detail mm</th><th>blur px</th><th>pictures</th><th>not seen "
        "%</th></tr>";
    for (const MapRow& row : section.rows)
        html += "<tr><td>" + escapeHtml(row.place) + "</td><td>" + fixed(row.pixelMm, 2) + "</td><td>" + fixed(row.detailMm, 2) +
                "</td><td>" + fixed(row.blurPx, 1) + "</td><td>" + fixed(row.pictures, 0) + "</td><td>" + fixed(100 * row.unseenShare, 0) +
                "</td></tr>";
    html += "</table>";
}

void addFigures(std::string& html, const char* heading, const std::vector<ReportFigure>& figures) {
    if (figures.empty()) return;
    html += "<h2>" + std::string(heading) + "</h2><table><tr><th>what</th><th>value</th><th>unit</th><th>bar</th><th></th></tr>";
    std::string group;
    for (const ReportFigure& f : figures) {
        if (f.group != group) html += "<tr><td colspan=5><b>" + escapeHtml(group = f.group) + "</b></td></tr>";
        html += "<tr><td>" + escapeHtml(f.name) + "</td><td>" + fixed(f.value, std::abs(f.value) >= 1000 ? 0 : 3) + "</td><td class=text>" +
                escapeHtml(f.unit) + "</td>" + barCells(f) + "</tr>";
    }
    html += "</table>";
}

void addStages(std::string& html, const ReportData& data) {
    double total = 0;
    for (const StageCost& s : data.stages) total += s.seconds;
    html += "<h2>Time and memory</h2><table><tr><th>stage</th><th>seconds</th><th>peak memory MiB</th><th></th></tr>";
    for (const StageCost& s : data.stages)
        html += "<tr><td>" + escapeHtml(s.name) + (s.reused ? " <span class=soft>(earlier run)</span>" : "") + "</td><td>" +
                fixed(s.seconds, 1) + "</td><td>" + fixed(double(s.peakBytes) / (1 << 20), 0) +
                "</td><td class=text><span class=bar style=\"width:" + fixed(total > 0 ? s.seconds / total * 300 : 0, 0) +
                "px\"></span></td></tr>";
    html += "<tr><td><b>all</b></td><td><b>" + fixed(total, 1) + "</b></td><td></td><td></td></tr></table>";
}

void addEvidence(std::string& html, const ReportData& data) {
    if (data.evidence.empty()) return;
    html +=
        "<h2>Evidence: what is in the file, and why</h2><table><tr><th>part</th><th>kept</th><th>gain "
        "dB</th><th>bytes</th><th>reason</th></tr>";
    for (const EvidenceData& e : data.evidence)
        html += "<tr><td>" + escapeHtml(e.part) + "</td><td>" + (e.kept ? "yes" : "no") + "</td><td>" +
                (e.gainDb != 0 ? fixed(e.gainDb, 2) : "–") + "</td><td>" + std::to_string(e.bytes) + "</td><td class=text>" +
                escapeHtml(e.reason) + "</td></tr>";
    html += "</table>";
}

}  // namespace

std::string reportHtml(const ReportData& data) {
    std::string html = "<!doctype html><html lang=en><meta charset=utf-8><meta name=viewport content=\"width=device-width\"><title>" +
                       escapeHtml(data.title) + "</title><style>" + kStyle + "</style><h1>" + escapeHtml(data.title) +
                       "</h1><p class=soft>";
    for (const auto& [name, value] : data.facts) html += escapeHtml(name) + ": " + escapeHtml(value) + " · ";
    html += "</p>";
    addFilmAgain(html, data.filmAgain);
    html +=
        "<h2>Quality on held-out frames</h2><p class=soft>No held-out picture was used to make the avatar. Only the pose fit uses "
        "them: "
        "it moves the finished avatar to match each picture.</p>";
    for (const std::string& sentence : data.provenance) html += "<p><b>" + escapeHtml(sentence) + "</b></p>";
    addScores(html, data);
    addFigures(html, "Above the floors", floorFigures(data.frames));
    addPictures(html, data);
    html += "<h2>Scan check</h2><pre>" + escapeHtml(data.verdict) + "</pre>";
    if (!data.lossCurves.empty() || !data.psnrCurves.empty()) {
        html += "<h2>Training</h2>";
        if (!data.lossCurves.empty()) html += svgPlot(data.lossCurves, {.title = "Loss", .xLabel = "step", .yLabel = "loss", .logY = true});
        if (!data.psnrCurves.empty())
            html += svgPlot(data.psnrCurves, {.title = "PSNR on training frames", .xLabel = "step", .yLabel = "dB"});
    }
    addFigures(html, "Registration and sizes", data.figures);
    addFigures(html, "Error waterfall: what each stage costs", data.waterfall);
    if (data.ladder) html += ladderHtml(*data.ladder);
    addStages(html, data);
    addEvidence(html, data);
    if (!data.limits.empty()) {
        html += "<h2>What this version does not do</h2><ul>";
        for (const std::string& limit : data.limits) html += "<li>" + escapeHtml(limit) + "</li>";
        html += "</ul>";
    }
    return html + "</html>\n";
}

}  // namespace dpl
