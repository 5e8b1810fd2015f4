// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/report/report.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "reconstruction/judging/report/plain_words.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

using nlohmann::ordered_json;

constexpr std::pair<const char*, double FrameScore::*> kScores[] = {
    {"masked_psnr_db", &FrameScore::maskedPsnrDb}, {"masked_ssim", &FrameScore::maskedSsim}, {"alpha_iou", &FrameScore::alphaIou},
    {"full_psnr_db", &FrameScore::fullPsnrDb},     {"full_ssim", &FrameScore::fullSsim},     {"coverage", &FrameScore::coverage},
    {"union_psnr_db", &FrameScore::unionPsnrDb},   {"union_ssim", &FrameScore::unionSsim},   {"uncovered", &FrameScore::uncovered},
    {"drawn_outside", &FrameScore::drawnOutside},  {"lone_px", &FrameScore::lonePx}};

ordered_json scoreJson(const FrameScore& s) {
    ordered_json out;
    for (const auto& [name, member] : kScores) out[name] = s.*member;
    return out;
}

ordered_json figuresJson(const std::vector<ReportFigure>& figures) {
    ordered_json list = ordered_json::array();
    for (const ReportFigure& f : figures) {
        list.push_back({{"key", f.key}, {"group", f.group}, {"name", f.name}, {"value", f.value}, {"unit", f.unit}});
        if (f.bar) list.back()["bar"] = {{f.bar->atLeast ? "at_least" : "at_most", f.bar->value}, {"met", meetsBar(f)}};
    }
    return list;
}

std::string number(double value) {
    char text[48];
    std::snprintf(text, sizeof text, "%.4g", value);
    return text;
}

}  // namespace

bool meetsBar(const ReportFigure& f) {
    return f.bar && (f.bar->atLeast ? f.value >= f.bar->value : f.value <= f.bar->value);
}

std::vector<ReportFigure> floorFigures(const std::vector<HeldOutFrame>& frames) {
    constexpr double kAboveFloorsDb = 4;
    std::vector<ReportFigure> figures;
    for (const FrameKind kind : {FrameKind::StaticFull, FrameKind::Dynamic}) {
        const auto avatar = meanScore(frames, kind, &HeldOutFrame::withPoseFit);
        if (!avatar) continue;
        const double floor = std::max(meanScore(frames, kind, &HeldOutFrame::labelFloor)->maskedPsnrDb,
                                      meanScore(frames, kind, &HeldOutFrame::meshFloor)->maskedPsnrDb);
        figures.push_back({std::string("above_floor.") + shortKindName(kind), "masked PSNR above the better floor",
                           std::string("held-out ") + shortKindName(kind), "dB", avatar->maskedPsnrDb - floor,
                           ReportBar{kAboveFloorsDb, true}});
    }
    return figures;
}

std::string barSummary(const ReportData& data) {
    std::vector<ReportFigure> figures = floorFigures(data.frames);
    figures.insert(figures.end(), data.figures.begin(), data.figures.end());
    size_t bars = 0, met = 0;
    std::string missed;
    for (const ReportFigure& f : figures) {
        if (!f.bar) continue;
        ++bars;
        if (meetsBar(f)) {
            ++met;
            continue;
        }
        missed += (missed.empty() ? "; missed: " : ", ") + f.group + ": " + f.name + " " + number(f.value) + " " + f.unit + " (bar: at " +
                  (f.bar->atLeast ? "least " : "most ") + number(f.bar->value) + ")";
    }
    return bars ? std::to_string(met) + " of " + std::to_string(bars) + " bars met" + missed : "";
}

std::optional<FrameScore> meanScore(const std::vector<HeldOutFrame>& frames, FrameKind kind, FrameScore HeldOutFrame::*which) {
    FrameScore sum;
    size_t count = 0;
    for (const HeldOutFrame& frame : frames) {
        if (frame.kind != kind) continue;
        for (const auto& [name, member] : kScores) sum.*member += (frame.*which).*member;
        ++count;
    }
    if (count == 0) return std::nullopt;
    for (const auto& [name, member] : kScores) sum.*member /= double(count);
    return sum;
}

std::string reportJson(const ReportData& data) {
    ordered_json out;
    out["title"] = data.title;
    out["word"] = wordOf(worthOf(data));
    out["in_words"] = verdictSentence(data);
    for (const auto& [name, value] : data.facts) out["facts"][name] = value;
    out["film_again"] = data.filmAgain.advice;
    out["body_map"] = ordered_json::array();
    for (const MapRow& row : data.filmAgain.rows)
        out["body_map"].push_back({{"place", row.place},
                                   {"mm_per_pixel", row.pixelMm},
                                   {"finest_detail_mm", row.detailMm},
                                   {"blur_px", row.blurPx},
                                   {"pictures", row.pictures},
                                   {"not_seen", row.unseenShare}});
    out["provenance"] = data.provenance;
    out["verdict"] = data.verdict;
    const std::pair<const char*, FrameScore HeldOutFrame::*> columns[] = {{"with_pose_fit", &HeldOutFrame::withPoseFit},
                                                                          {"without_pose_fit", &HeldOutFrame::withoutPoseFit},
                                                                          {"floor_flat_labels", &HeldOutFrame::labelFloor},
                                                                          {"floor_vertex_colours", &HeldOutFrame::meshFloor}};
    for (const FrameKind kind : {FrameKind::StaticFull, FrameKind::Dynamic})
        for (const auto& [name, member] : columns)
            if (auto mean = meanScore(data.frames, kind, member)) out["means"][shortKindName(kind)][name] = scoreJson(*mean);
    for (const auto& [key, frames] : {std::pair{"frames", &data.frames}, {"validation_frames", &data.validation}}) {
        out[key] = ordered_json::array();
        for (const HeldOutFrame& frame : *frames) {
            ordered_json entry = {{"name", frame.name}, {"kind", shortKindName(frame.kind)}};
            for (const auto& [name, member] : columns) entry[name] = scoreJson(frame.*member);
            out[key].push_back(std::move(entry));
        }
    }
    out["stages"] = ordered_json::array();
    for (const StageCost& s : data.stages)
        out["stages"].push_back({{"name", s.name}, {"seconds", s.seconds}, {"peak_bytes", s.peakBytes}, {"reused", s.reused}});
    out["above_floors"] = figuresJson(floorFigures(data.frames));
    out["figures"] = figuresJson(data.figures);
    out["waterfall"] = figuresJson(data.waterfall);
    if (data.ladder) out["ladder"] = ladderJson(*data.ladder);
    if (data.ladder && !data.ladder->garments.empty()) out["garments"] = garmentsJson(*data.ladder);
    out["evidence"] = ordered_json::array();
    for (const EvidenceData& e : data.evidence)
        out["evidence"].push_back({{"part", e.part}, {"kept", e.kept}, {"gain_db", e.gainDb}, {"bytes", e.bytes}, {"reason", e.reason}});
    out["limits"] = leftOut(data.evidence);
    return out.dump(1);
}

Status writeReport(const ReportData& data, const std::filesystem::path& folder) {
    DPL_RETURN_IF_ERROR(writeFileAtomically(folder / "report.json", reportJson(data)));
    return writeFileAtomically(folder / "report.html", reportHtml(data));
}

}  // namespace dpl
