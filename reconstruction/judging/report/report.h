// SPDX-License-Identifier: Apache-2.0
// The report of one reconstruction: report.json for programs, a self-contained report.html for people.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "reconstruction/input/capture/scan.h"
#include "reconstruction/judging/report/ladder_table.h"
#include "reconstruction/judging/report/svg_plot.h"
#include "reconstruction/output/page/web_module.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Scores of one picture against its frame (docs/reference/metrics.md). Masked scores use only pixels inside the frame's mask, those of the
 *  union also what is drawn outside of it. */
struct FrameScore {
    double maskedPsnrDb = 0;  // lowest over white, black and grey, with both pictures composited on it
    double maskedSsim = 0;    // mean SSIM inside the mask, lowest over the same three
    double alphaIou = 0;      // of the pixels ≥ 128 in the picture's alpha and in the mask
    double fullPsnrDb = 0;    // whole frame over white, truth cut out by its mask, as in papers
    double fullSsim = 0;      // as fullPsnrDb
    double coverage = 0;      // share of the frame inside the mask; a small share raises full-frame scores
    double unionPsnrDb = 0;   // as maskedPsnrDb, over pixels ≥ 128 in the mask or in the picture's alpha: drawing too wide counts
    double unionSsim = 0;     // as maskedSsim, over the same pixels
    double uncovered = 0;     // mask pixels whose drawn alpha is < 128, over mask pixels
    double drawnOutside = 0;  // pixels with drawn alpha ≥ 128 outside the mask, over mask pixels
    double lonePx = 0;        // pixels of drawn parts that stand free of the person (loneParts)
};

/** Scores and pictures of one held-out frame. */
struct HeldOutFrame {
    std::string name;
    FrameKind kind = FrameKind::StaticFull;
    FrameScore withoutPoseFit, withPoseFit;
    FrameScore labelFloor, meshFloor;  // baselines: one colour a label inside the frame's mask; posed mesh with vertex colours
    std::vector<uint8_t> truthPng, renderPng, differencePng;  // for report.html; may be empty
    std::vector<float> onSurface;                             // F, differenceOnSurface(); for report.html; may be empty
};

struct StageCost {
    std::string name;
    double seconds = 0;
    uint64_t peakBytes = 0;
    bool reused = false;
};

/** The limit that a figure must keep. */
struct ReportBar {
    double value = 0;
    bool atLeast = true;  // false: at most
};

/** A figure with its unit. Programs find it by its key, which names parts from large to small ("truth.body_fit.keypoints_mean") and stays;
 *  group and name are for people. No two figures of a report have the same key. */
struct ReportFigure {
    std::string key;
    std::string group, name, unit;
    double value = 0;
    std::optional<ReportBar> bar;
};

/** Whether the figure has a bar and meets it. NaN misses every bar. */
bool meetsBar(const ReportFigure& figure);

/** One row of the body map (docs/reference/body-map.md): medians over a place of the body; 0 when no picture shows it. */
struct MapRow {
    std::string key, place;  // "left_hand", "the left hand"
    double pixelMm = 0, detailMm = 0, blurPx = 0, pictures = 0;
    double unseenShare = 0;  // share of its area that no still training picture shows
};

/** One piece of advice. */
struct AdviceCard {
    std::string sentence;       // "Film the left hand from 40 cm, slowly from all sides: it is seen at 4 mm a pixel"
    std::vector<uint8_t> jpeg;  // what the shot looks like; empty: no picture
};

/** What to film again, and the map that says so. */
struct FilmAgainSection {
    std::string advice;                 // one line of heading, then a numbered line each; or that nothing is needed
    std::vector<AdviceCard> cards;      // the same, the most helpful first
    std::vector<std::string> warnings;  // of the scan check, one sentence each
    std::vector<MapRow> rows;
    std::vector<std::vector<uint8_t>> pictures;  // PNG; may be empty
};

/** The picture of the person that opens the page. */
struct Portrait {
    std::vector<uint8_t> png;    // empty: none
    std::vector<uint8_t> small;  // the same as a small JPEG, for lists of many avatars; empty: none
    std::string frame;           // whose camera drew it
};

/** A few pictures that are shown one after the other, in a loop. */
struct ReportClip {
    std::string title;
    double seconds = 0;                       // of the loop
    std::vector<std::vector<uint8_t>> jpegs;  // of one size
};

/** How long the avatar was trained, for the sentence that tells a draft. 0: not known. */
struct TrainingLength {
    uint32_t steps = 0;
    uint32_t standardSteps = 0;  // of the preset standard
};

/** What lets the person of the portrait move in the page. */
struct LivePerson {
    WebModule module;
    std::vector<uint8_t> avatar;  // the bytes of a .glb
};

struct ReportData {
    std::string title;
    std::string avatarFile;  // name of the file beside report.html, for its links; empty: none
    Portrait portrait;
    std::optional<LivePerson> live;
    std::string whyStill;  // a sentence below a portrait that stays a picture; may be empty
    TrainingLength length;
    FilmAgainSection filmAgain;
    std::vector<ReportClip> clips;
    std::vector<std::pair<std::string, std::string>> facts;  // scan, body, preset, seed, ...
    std::vector<std::string> provenance;                     // what the figures stand for, one sentence each (provenance.h)
    std::string verdict;                                     // result of the scan check, several lines
    std::vector<HeldOutFrame> frames;                        // held out
    std::vector<uint8_t> errorMap;                           // PNG of drawErrorMap(); empty: none
    std::vector<HeldOutFrame> validation;                    // set aside for decisions, without pictures
    std::vector<StageCost> stages;
    std::vector<PlotSeries> lossCurves, psnrCurves;
    std::vector<ReportFigure> figures;    // registration residuals, truth comparison, sizes
    std::vector<ReportFigure> waterfall;  // dB lost by each stage, for scans with truth
    std::optional<Ladder> ladder;         // of scans with a truth
    std::vector<EvidenceData> evidence;
};

/** Mean over the frames of a kind; nullopt when there are none. */
std::optional<FrameScore> meanScore(const std::vector<HeldOutFrame>& frames, FrameKind kind, FrameScore HeldOutFrame::*which);

/** dB by which the avatar scores above the better of its two floors, one figure a kind of frame. The bar is 4 dB: below it the splats add
 *  little to flat colours in the true outline or to a painted mesh. */
std::vector<ReportFigure> floorFigures(const std::vector<HeldOutFrame>& frames);

/** "5 of 6 bars met; missed: keypoints, mean 16.1 mm (bar: at most 15)". Empty without bars. Counts the bars of floorFigures too. */
std::string barSummary(const ReportData& data);

std::string reportJson(const ReportData& data);
std::string reportHtml(const ReportData& data);

/** The page of a run that has not ended yet, or was stopped: how to go on, and what to film again. */
std::string unfinishedHtml(const std::string& title, const FilmAgainSection& filmAgain);

/** Writes report.json and report.html into `folder`, each atomically. */
Status writeReport(const ReportData& data, const std::filesystem::path& folder);

}  // namespace dpl
