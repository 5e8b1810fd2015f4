// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>

#include "reconstruction/judging/report/html_table.h"
#include "reconstruction/judging/report/plain_words.h"
#include "reconstruction/judging/report/report.h"

namespace dpl {
namespace {

constexpr const char* kStyle = R"(
:root{color-scheme:light dark;--fg:#1f2937;--soft:#6b7280;--line:#e5e7eb;--card:#f9fafb;--accent:#2563eb;--good:#15803d;--bad:#b91c1c}
@media(prefers-color-scheme:dark){:root{--fg:#e5e7eb;--soft:#9ca3af;--line:#374151;--card:#1f2937;--accent:#60a5fa;--good:#4ade80;--bad:#f87171}
body{background:#111827}}
body{font:15px/1.5 system-ui,sans-serif;color:var(--fg);max-width:1080px;margin:1rem auto 2rem;padding:0 1rem;overflow-wrap:break-word}
h1{margin:0 0 .4rem;line-height:1.2}h2{margin-top:2.2rem;border-bottom:1px solid var(--line);padding-bottom:.2rem}
img{max-width:100%}.top{display:flex;gap:1.6rem;align-items:center}.top>*{min-width:0}.top figure{margin:0;flex:0 1 auto}
.top img{display:block;max-height:min(30rem,58vh);border-radius:.5rem;background:#fff}.top div{flex:1 1 0}
.verdict{font-size:1.25rem;line-height:1.4;margin:.4rem 0}.soft{color:var(--soft)}.lines{white-space:pre-line}
@media(max-width:640px){.top{flex-direction:column;align-items:flex-start;gap:.6rem}.verdict{font-size:1.1rem}h1{font-size:1.6rem}}
.scroll{overflow-x:auto;margin:.8rem 0}table{border-collapse:collapse;font-variant-numeric:tabular-nums}
th,td{padding:.25rem .8rem;border-bottom:1px solid var(--line);text-align:right}th:first-child,td:first-child{text-align:left}
td:first-child{min-width:8rem}td.text{text-align:left}td.reason{text-align:left;min-width:18rem}
pre{background:var(--card);padding:.8rem;white-space:pre-wrap;overflow-wrap:anywhere}
.big{display:flex;gap:1rem;flex-wrap:wrap}.big div{background:var(--card);border-radius:.5rem;padding:.7rem 1.1rem}.big b{display:block;font-size:1.7rem}
.pictures{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(320px,100%),1fr));gap:1rem}
.pictures figure{margin:0;background:var(--card);border-radius:.5rem;padding:.5rem}.pictures img{width:32.6%}
.maps{display:flex;flex-wrap:wrap;gap:1rem}summary{cursor:pointer;font-size:1.3rem;font-weight:bold;margin-top:2.2rem}
.plot text{font:11px system-ui;fill:var(--soft)}.plot text.title{font-size:13px;fill:var(--fg)}.plot .grid{stroke:var(--line)}
.bar{background:var(--accent);height:.8rem;display:inline-block;border-radius:2px}.met{color:var(--good)}.missed{color:var(--bad);font-weight:bold}
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

std::string picture(const std::vector<uint8_t>& png, const std::string& what) {
    if (png.empty()) return {};
    return "<img alt=\"" + escapeHtml(what) + "\" title=\"" + escapeHtml(what) + "\" src=\"data:image/png;base64," + base64(png) + "\">";
}

std::string scoreRow(const std::string& name, const FrameScore& s) {
    return "<tr><td>" + escapeHtml(name) + "</td><td>" + fixed(s.maskedPsnrDb, 2) + "</td><td>" + fixed(s.maskedSsim, 4) + "</td><td>" +
           fixed(s.alphaIou, 4) + "</td><td>" + fixed(s.unionPsnrDb, 2) + "</td><td>" + fixed(s.unionSsim, 4) + "</td><td>" +
           fixed(100 * s.uncovered, 2) + "</td><td>" + fixed(100 * s.drawnOutside, 2) + "</td><td>" + fixed(s.fullPsnrDb, 2) + "</td><td>" +
           fixed(s.fullSsim, 4) + "</td></tr>";
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
        html += "<h3>Held-out " + std::string(shortKindName(kind)) + " frames (" + std::to_string(count) + ")</h3><div class=big><div><b>" +
                fixed(fitted->maskedPsnrDb, 2) + " dB</b>masked PSNR</div><div><b>" + fixed(fitted->alphaIou, 4) +
                "</b>alpha IoU</div><div><b>" + fixed(fitted->maskedSsim, 4) + "</b>masked SSIM</div></div>" + kTableBegin +
                "<tr><th>mean of</th><th>masked PSNR dB</th><th>masked SSIM</th><th>alpha IoU</th><th>union PSNR dB</th><th>union "
                "SSIM</th><th>uncovered %</th><th>drawn outside %</th><th>full-frame PSNR dB</th><th>full-frame SSIM</th></tr>";
        html += scoreRow("avatar, with test-time pose fit", *fitted);
        html += scoreRow("avatar, without", *meanScore(data.frames, kind, &HeldOutFrame::withoutPoseFit));
        html += scoreRow("floor: one flat colour per label, true mask", *meanScore(data.frames, kind, &HeldOutFrame::labelFloor));
        html += scoreRow("floor: posed mesh, fitted vertex colours", *meanScore(data.frames, kind, &HeldOutFrame::meshFloor));
        html += kTableEnd +
                std::string(
                    "<p class=soft>Masked: inside the true mask, the render's own alpha over white, black and grey, worst of the three. "
                    "Union: the same over the mask and what is drawn outside of it. Uncovered and drawn outside: pixels over those of "
                    "the mask. Full-frame: on white, "
                    "truth cut out with its mask; the person covers ") +
                fixed(fitted->coverage * 100, 1) + " % of the frame, so white flatters these figures.</p>";
    }
}

void addPictures(std::string& html, const ReportData& data) {
    bool any = false;
    for (const HeldOutFrame& frame : data.frames) any |= !frame.renderPng.empty();
    if (!any) return;
    html +=
        "<h2>The avatar beside its pictures</h2><p class=soft>Left the picture, in the middle the avatar, right their difference, four "
        "times as strong. The avatar was not made from these pictures; only its pose was fitted to each.</p><div class=pictures>";
    for (const HeldOutFrame& frame : data.frames) {
        if (frame.renderPng.empty()) continue;
        html += "<figure>" + picture(frame.truthPng, "picture") + picture(frame.renderPng, "avatar") +
                picture(frame.differencePng, "difference") + "<figcaption>" + escapeHtml(frame.name) + " <span class=soft>" +
                fixed(frame.withPoseFit.maskedPsnrDb, 2) + " dB · IoU " + fixed(frame.withPoseFit.alphaIou, 3) + " · uncovered " +
                fixed(100 * frame.withPoseFit.uncovered, 1) + " % · outside " + fixed(100 * frame.withPoseFit.drawnOutside, 1) +
                " %</span></figcaption></figure>";
    }
    html += "</div>";
}

/** The person and what the run is worth, for the first screen. The picture comes first, so that no text can push it off. */
void addTop(std::string& html, const ReportData& data) {
    html += "<header class=top>";
    if (!data.portrait.png.empty())
        html += "<figure>" + picture(data.portrait.png, ("the avatar, drawn as the camera of " + data.portrait.frame + " saw the person")) +
                "</figure>";
    html += "<div><h1>" + escapeHtml(data.title) + "</h1><p class=verdict>" + escapeHtml(verdictSentence(data)) + "</p>";
    if (const std::string draft = draftSentence(data); !draft.empty()) html += "<p class=soft>" + escapeHtml(draft) + "</p>";
    html += "</div></header>";
}

void addList(std::string& html, const std::vector<std::string>& sentences) {
    html += "<ul>";
    for (const std::string& sentence : sentences) html += "<li>" + escapeHtml(sentence) + "</li>";
    html += "</ul>";
}

/** Numbered lines become a list. The line above them says what the section's heading says. */
void addAdvice(std::string& html, const std::string& advice) {
    std::string list;
    for (size_t at = 0; at < advice.size();) {
        const size_t end = std::min(advice.find('\n', at), advice.size());
        const std::string line = advice.substr(at, end - at);
        const size_t text = line.find(". ");
        if (line.starts_with("  ") && text != std::string::npos) list += "<li>" + escapeHtml(line.substr(text + 2)) + "</li>";
        at = end + 1;
    }
    html += list.empty() ? "<p class=lines>" + escapeHtml(advice) + "</p>" : "<p>The most helpful first:</p><ol>" + list + "</ol>";
}

/** Stands early, because it is what the reader can change. */
void addFilmAgain(std::string& html, const FilmAgainSection& section) {
    if (section.advice.empty() && section.warnings.empty()) return;
    html += "<h2>What to film again</h2>";
    addAdvice(html, section.advice);
    if (!section.warnings.empty()) {
        html += "<p>The check of the pictures warns:</p>";
        addList(html, section.warnings);
    }
    if (section.pictures.empty()) return;
    html += "<p class=soft>What the still pictures show of each place of the body. Bright is good.</p><div class=maps>";
    for (const std::vector<uint8_t>& png : section.pictures) html += picture(png, "body map");
    html += "</div>";
}

void addMapRows(std::string& html, const std::vector<MapRow>& rows) {
    if (rows.empty()) return;
    html += "<h2>Body map</h2>" + std::string(kTableBegin) +
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
    html += "<details><summary>Figures, and how they were measured</summary><p class=soft>";
    for (const auto& [name, value] : data.facts) html += escapeHtml(name) + ": " + escapeHtml(value) + "<br>";
    html += "</p>";
    addQuality(html, data);
    addMapRows(html, data.filmAgain.rows);
    if (!data.verdict.empty()) html += "<h2>Scan check</h2><pre>" + escapeHtml(data.verdict) + "</pre>";
    addTraining(html, data);
    addFigures(html, "Registration and sizes", data.figures);
    addFigures(html, "Error waterfall: what each stage costs", data.waterfall);
    if (data.ladder) html += ladderHtml(*data.ladder);
    addStages(html, data);
    addEvidence(html, data);
    html += "</details>";
}

}  // namespace

std::string reportHtml(const ReportData& data) {
    std::string html =
        "<!doctype html><html lang=en><meta charset=utf-8><meta name=viewport content=\"width=device-width,initial-scale=1\"><title>" +
        escapeHtml(data.title) + "</title><style>" + kStyle + "</style>";
    addTop(html, data);
    addFilmAgain(html, data.filmAgain);
    addPictures(html, data);
    if (const std::vector<std::string> parts = leftOut(data.evidence); !parts.empty()) {
        html += "<h2>What this avatar does not have</h2>";
        addList(html, parts);
    }
    addDetails(html, data);
    return html + "</html>\n";
}

}  // namespace dpl
