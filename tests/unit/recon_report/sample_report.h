// SPDX-License-Identifier: Apache-2.0
// Reports as runs make them, with every section filled by the longest words that runs write.
#pragma once

#include "reconstruction/base/image_codec.h"
#include "reconstruction/judging/report/provenance.h"
#include "reconstruction/judging/report/report.h"
#include "tests/unit/must.h"

namespace dpl::test {

/** A PNG with a ramp of grey. */
inline std::vector<uint8_t> rampPng(uint32_t widthPx, uint32_t heightPx) {
    std::vector<uint8_t> pixels(size_t(widthPx) * heightPx);
    for (size_t i = 0; i < pixels.size(); ++i) pixels[i] = uint8_t(i / widthPx * 255 / heightPx);
    return must(encodePng(pixels, widthPx, heightPx, 1));
}

/** A scan with a truth. */
inline ReportData fullReport(uint32_t portraitWidthPx = 420, uint32_t portraitHeightPx = 960) {
    ReportData data;
    data.title = "Doppel: a-scan-with-a-name-that-somebody-typed-without-any-space";
    data.portrait = {rampPng(portraitWidthPx, portraitHeightPx), {}, "full_001"};
    data.length = {300, 10000};
    data.facts = {{"scan", "scan"}, {"content hash", "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08"}};
    data.filmAgain.advice =
        "What to film again, the most helpful first:\n"
        "  1. Film the face from 60 cm, slower or in more light: its pictures are blurred by 2.1 px, so no detail below 3.4 mm shows\n"
        "  2. Walk round the person once more: 31 % of what shows there is in no still picture\n";
    const std::vector<uint8_t> shot = must(encodeJpeg(std::vector<uint8_t>(234 * 312 * 3, 128), 234, 312, 3, 80));
    data.filmAgain.cards = {
        {"Film the face from 60 cm, slower or in more light: its pictures are blurred by 2.1 px, so no detail below 3.4 mm shows", shot},
        {"Walk round the person once more: 31 % of what shows there is in no still picture", shot},
        {"Film the feet from above", {}},
        {"Film these moves too: bow and twist to both sides. Clothes learn only from moves that are filmed", shot}};
    data.clips = {{"The avatar walking", 2, std::vector<std::vector<uint8_t>>(4, shot)}};
    data.avatarFile = "avatar.glb";
    data.filmAgain.warnings = {"3 pictures are much softer than the others of their kind; they are left out"};
    data.filmAgain.rows = {{"face", "the face", 1.2, 2.3, 0.8, 12, 0.01}, {"left_hand", "the left hand", 2.2, 4.3, 1.8, 2, 0.41}};
    for (int i = 0; i < 3; ++i) data.filmAgain.pictures.push_back(rampPng(460, 412));
    data.provenance = provenanceOf("procedural-1", true);
    data.verdict =
        "Scan a (" + std::string(200, 'p') + ")\n  poses       " + std::string(150, 'x') + " " + std::string(90, 'y') + "\nPASS\n";
    for (const FrameKind kind : {FrameKind::StaticFull, FrameKind::Dynamic})
        for (int i = 0; i < 2; ++i) {
            HeldOutFrame frame{.name = shortKindName(kind) + std::to_string(i), .kind = kind};
            frame.withPoseFit = {24.5, 0.91, 0.98, 30, 0.99, 0.1, 22.1, 0.88, 0.012, 0.034};
            frame.withoutPoseFit = {22.5, 0.90, 0.97, 29, 0.98, 0.1, 21.1, 0.87, 0.022, 0.044};
            frame.labelFloor = {17, 0.7, 1, 20, 0.9, 0.1}, frame.meshFloor = {18, 0.7, 0.9, 20, 0.9, 0.1};
            frame.truthPng = frame.renderPng = frame.differencePng = rampPng(120, 260);
            data.frames.push_back(frame);
        }
    data.errorMap = rampPng(460, 412);
    data.stages = {{"co-optimise", 1800, uint64_t(3) << 30, false}, {"report", 20, uint64_t(1) << 30, true}};
    data.lossCurves = {{"total", {0, 1, 2}, {0.5, 0.1, 0.02}}};
    data.psnrCurves = {{"masked", {0, 1, 2}, {15, 20, 24}}};
    data.figures = {
        {"truth.pose_fit.keypoints_mean", "registration against the truth, held-out dynamic frames, after training and pose fit",
         "keypoints, mean", "mm", 16.1, ReportBar{15, false}},
        {"file.bytes", "avatar file", "whole file", "bytes", 1234567, {}}};
    data.waterfall = {{"static.pose_fit", "static", "registration of held-out frames (pose fit on against off)", "dB", 2, {}}};
    Ladder ladder;
    for (const Split split : {Split::Train, Split::Validation, Split::Test})
        for (const FrameKind kind : {FrameKind::StaticFull, FrameKind::Dynamic}) ladder.groups.push_back({kind, split, 12});
    ladder.rungs = {{"as_is", "as it is, in its registered poses", std::vector<LadderCell>(6, LadderCell{12, 22.4, 31.0})}};
    ladder.garments = {{"skirt", GarmentPoses::True, std::vector<GarmentCell>(6, GarmentCell{12, 31.2, 40.1, 41.3, 52.4})}};
    data.ladder = ladder;
    data.evidence = {{"garment layer: skirt", true, 0, 0, "1204 triangles, 0.61 m²"},
                     {"garment layer: scarf", false, 0, 0, "no picture shows the label scarf"},
                     {"pose-dependent offsets", true, 0.41f, 20480, "masked PSNR of 8 validation frames; 20 KB must gain 0.054 dB"},
                     {"pose-dependent light", false, 0.01f, 0, "masked PSNR of 8 validation frames; 20 KB must gain 0.054 dB"},
                     {"view-dependent colour (SH degree 0)", false, 0, 0, "not trained"}};
    return data;
}

/** A scan without a truth, of which no frame was held out, in one layer: nothing is scored. */
inline ReportData bareReport() {
    ReportData data;
    data.title = "Doppel: ada";
    data.portrait = {rampPng(960, 700), {}, "full_001"};
    data.filmAgain.advice = "Nothing needs to be filmed again: the face 1.2 mm\n";
    data.verdict = "PASS\n";
    data.evidence = {{"garment layers", false, 0, 0, "no still full-body picture, and layers are cut from those"}};
    return data;
}

/** A module and an avatar that nobody runs, for the text and the layout of a living page. */
inline LivePerson someLife() {
    return {{{93, 0, 0, 1, 0},
             "console.log('alive');",
             "#person{margin:0}#person .stage{position:relative;height:40vh;aspect-ratio:3/4}#person .stage "
             "img{width:100%;height:100%;object-fit:contain}"},
            {1, 2, 3}};
}

}  // namespace dpl::test
