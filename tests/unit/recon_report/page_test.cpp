// SPDX-License-Identifier: Apache-2.0
// The page of the report as a person meets it: what comes first, what it says in words, what it leaves to engineers.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>

#include "reconstruction/judging/report/plain_words.h"
#include "tests/unit/recon_report/sample_report.h"

namespace dpl::test {
namespace {

size_t countOf(const std::string& text, std::string_view part) {
    size_t count = 0;
    for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
    return count;
}

/** The page without the bytes of its pictures. */
std::string pageOf(const ReportData& data) {
    return std::regex_replace(reportHtml(data), std::regex("base64,[^\"]*"), "base64,");
}

HeldOutFrame frameAt(FrameKind kind, double maskedPsnrDb) {
    HeldOutFrame frame{.name = "f", .kind = kind};
    frame.withPoseFit.maskedPsnrDb = maskedPsnrDb;
    return frame;
}

TEST(ReportPage, opensWithThePersonAndTheVerdict) {
    const ReportData data = fullReport();
    const std::string page = pageOf(data);
    const size_t person = page.find("<img alt=\"the avatar, drawn as the camera of full_001 saw the person\"");
    const size_t verdict = page.find("<p class=verdict>" + verdictSentence(data) + "</p>");
    ASSERT_NE(person, std::string::npos);
    ASSERT_NE(verdict, std::string::npos);
    EXPECT_EQ(person, page.find("<img"));
    EXPECT_LT(person, page.find("<h1>")) << "text before the picture could push it off the first screen";
    for (const char* later : {"<h2>", "<table>", "<svg", "<details class=engineers>"}) {
        ASSERT_NE(page.find(later), std::string::npos) << later;
        EXPECT_LT(verdict, page.find(later)) << later;
    }
    EXPECT_LT(page.find("What to film again"), page.find("The avatar beside its pictures"));
    EXPECT_LT(page.find("The avatar beside its pictures"), page.find("<h2>Where it differs</h2>"));
    EXPECT_LT(page.find("<h2>Where it differs</h2>"), page.find("<details class=engineers>"));
}

TEST(ReportPage, figuresOfEngineersAreFoldedAndAllThere) {
    const std::string page = pageOf(fullReport());
    const size_t details = page.find("<details class=engineers>");
    EXPECT_EQ(page.find("<table>", 0), page.find("<table>", details)) << "no table before the fold";
    for (const char* word : {"PSNR", " dB", "IoU", "SSIM"}) EXPECT_EQ(page.substr(0, details).find(word), std::string::npos) << word;
    for (const char* heading : {"Quality on held-out frames", "Above the floors", "Body map", "Scan check", "Training",
                                "Registration and sizes", "Error waterfall", "The ladder", "Time and memory", "Evidence"}) {
        const size_t at = page.find(std::string("<h2>") + heading);
        ASSERT_NE(at, std::string::npos) << heading;
        EXPECT_GT(at, details) << heading;
    }
}

TEST(ReportPage, theLadderStatesPointsBesideTheNearestDistance) {
    const ReportData data = fullReport();
    const std::string text = ladderText(*data.ladder), page = pageOf(data);
    EXPECT_LT(text.find("31.2 of 40.1 (0.78)"), text.find("41.3 of 52.4 (0.79)"));
    EXPECT_EQ(countOf(text, "41.3 of 52.4 (0.79)"), 6u) << "one a group of frames";
    EXPECT_EQ(countOf(page, "<td>41.3 of 52.4 (0.79)</td>"), 6u);
    const auto cell = nlohmann::json::parse(reportJson(data))["garments"][0]["dynamic"]["test"];
    EXPECT_EQ(cell["point_corrected_mm"], 41.3);
    EXPECT_EQ(cell["point_plain_mm"], 52.4);
}

TEST(ReportPage, listsEveryPartThatTheAvatarLacksAndNoneThatItHas) {
    const ReportData data = fullReport();
    const std::string page = pageOf(data);
    const size_t from = page.find("<h2>What this avatar does not have</h2>");
    ASSERT_NE(from, std::string::npos);
    const std::string list = page.substr(from, page.find("</ul>", from) - from);
    for (const char* lacks : {"<li>scarf as a layer of its own: no picture shows the label scarf</li>",
                              "<li>light that follows the pose (pose-dependent light): the pictures were better with it, but too little "
                              "for its size in the file</li>",
                              "<li>gloss (view-dependent colour (SH degree 0)): not trained</li>"})
        EXPECT_NE(list.find(lacks), std::string::npos) << lacks;
    for (const char* has : {"skirt", "offsets"}) EXPECT_EQ(list.find(has), std::string::npos) << has;
    EXPECT_EQ(countOf(list, "<li>"), 3u);
    EXPECT_EQ(nlohmann::json::parse(reportJson(data))["limits"].size(), 3u);

    ReportData whole = data;
    for (EvidenceData& row : whole.evidence) row.kept = true;
    EXPECT_EQ(pageOf(whole).find("What this avatar does not have"), std::string::npos);
}

TEST(ReportPage, saysInWordsWhyAPartIsMissing) {
    const std::vector<std::string> said = leftOut({{"pose-dependent offsets", false, -0.2f, 0, "masked PSNR of 8 frames"},
                                                   {"garment layers", false, 0, 0, "left out by --without layers"},
                                                   {"a part of a later version", false, 0, 0, "not trained"}});
    EXPECT_EQ(said[0], "a surface that follows the pose (pose-dependent offsets): the pictures were better without it");
    EXPECT_EQ(said[1], "clothes as layers of their own (garment layers): left out by --without layers");
    EXPECT_EQ(said[2], "a part of a later version: not trained");
}

TEST(ReportPage, theVerdictFollowsTheFigures) {
    ReportData data;
    data.frames = {frameAt(FrameKind::StaticFull, 25), frameAt(FrameKind::StaticFull, 25.5), frameAt(FrameKind::Dynamic, 17)};
    EXPECT_EQ(verdictSentence(data),
              "Standing still, the avatar looks very close to the pictures; moving, it looks recognisable, but blurred or wrong in places "
              "(judged by 3 pictures that it was not made from).");
    data.frames = {frameAt(FrameKind::StaticFull, 21), frameAt(FrameKind::Dynamic, 20.5)};
    EXPECT_EQ(
        verdictSentence(data),
        "Standing still and moving, the avatar looks like the pictures, but softer (judged by 2 pictures that it was not made from).");
    data.frames = {frameAt(FrameKind::StaticFull, std::nan(""))};
    EXPECT_EQ(verdictSentence(data),
              "Standing still, the avatar looks only roughly like the person (judged by 1 picture that it was not made from).");
    data.frames.clear(), data.validation = {frameAt(FrameKind::Dynamic, 25)};
    EXPECT_TRUE(verdictSentence(data).starts_with("Moving, the avatar looks very close")) << "no frame was held out";
    EXPECT_EQ(nlohmann::json::parse(reportJson(data))["in_words"], verdictSentence(data));
    EXPECT_NE(verdictSentence({}).find("No picture was kept back"), std::string::npos);
}

TEST(ReportPage, saysSoOfADraft) {
    ReportData data = fullReport();
    EXPECT_NE(pageOf(data).find("trained for 300 steps. The preset standard trains for 10000"), std::string::npos);
    data.length = {10000, 10000};
    EXPECT_EQ(draftSentence(data), "");
    EXPECT_EQ(pageOf(data).find("This is a draft"), std::string::npos);
    EXPECT_EQ(draftSentence({}), "") << "doppel evaluate does not know how long an avatar was trained";
}

TEST(ReportPage, withoutScoresThereIsNoEmptySection) {
    const std::string page = pageOf(bareReport());
    EXPECT_NE(page.find("No picture was kept back to judge the avatar by"), std::string::npos);
    EXPECT_NE(page.find("No frame was held out, so nothing is scored here."), std::string::npos);
    for (const char* empty :
         {"The avatar beside its pictures", "Where it differs", "The ladder", "Training</h2>", "Time and memory", "Body map", "(judged by"})
        EXPECT_EQ(page.find(empty), std::string::npos) << empty;
    ReportData noPicture = bareReport();
    noPicture.portrait = {};
    EXPECT_EQ(pageOf(noPicture).find("<img"), std::string::npos);
}

TEST(ReportPage, threeCardsShowTheShotsAndTheRestIsAList) {
    const std::string page = pageOf(fullReport());
    EXPECT_EQ(countOf(page, "<div class=card>"), 3u);
    EXPECT_EQ(countOf(page, "alt=\"what the shot looks like\""), 2u) << "a card without a picture stays a card";
    EXPECT_NE(page.find("<p><b>Film the face from 60 cm, slower or in more light</b></p><p class=soft>Its pictures are blurred by 2.1 px"),
              std::string::npos);
    EXPECT_NE(page.find("<li>Film these moves too: bow and twist"), std::string::npos) << "the fourth is not lost";
    EXPECT_EQ(countOf(page, "What to film again"), 1u);
    ReportData data = bareReport();
    data.filmAgain.advice = "Nothing needs to be filmed again: the face 1.2 mm, <the chest> 2.1 mm\n";
    EXPECT_NE(pageOf(data).find("<p class=lines>Nothing needs to be filmed again: the face 1.2 mm, &lt;the chest&gt; 2.1 mm"),
              std::string::npos);
    EXPECT_EQ(countOf(pageOf(data), "class=card"), 0u);
}

TEST(ReportPage, aWordSaysWhatTheRunIsWorth) {
    const auto worth = [](double stillDb, double movingDb, std::vector<MapRow> rows) {
        ReportData data;
        data.frames = {frameAt(FrameKind::StaticFull, stillDb), frameAt(FrameKind::Dynamic, movingDb)};
        data.filmAgain.rows = std::move(rows);
        return worthOf(data);
    };
    const auto place = [](const char* key, double unseen) { return MapRow{key, key, 1, 1, 1, 9, unseen}; };
    EXPECT_EQ(worth(26, 20, {place("back", 0.25)}), Worth::Good);
    EXPECT_EQ(worth(26, 19.9, {}), Worth::Usable);
    EXPECT_EQ(worth(15.9, 26, {}), Worth::FilmAgain);
    EXPECT_EQ(worth(std::nan(""), 26, {}), Worth::FilmAgain);
    EXPECT_EQ(worth(26, 26, {place("left_hand", 0.9)}), Worth::Usable) << "a hand is soon filmed, and the rest is there";
    EXPECT_EQ(worth(26, 26, {place("back", 0.51)}), Worth::FilmAgain);
    EXPECT_EQ(worthOf({}), Worth::Usable) << "nothing judges it";

    ReportData data = fullReport();
    EXPECT_NE(pageOf(data).find("<p class=\"word usable\">Usable</p>"), std::string::npos) << "41 % of a hand is not seen";
    data.filmAgain.rows.clear();
    EXPECT_NE(pageOf(data).find("<p class=\"word good\">Good</p>"), std::string::npos);
    EXPECT_EQ(nlohmann::json::parse(reportJson(data))["word"], "Good");
    EXPECT_GT(pageOf(data).find(kWorthRule), pageOf(data).find("<details class=engineers>")) << "the rule is stated, and folded";
    EXPECT_NE(pageOf(data).find(kWorthRule), std::string::npos);
}

TEST(ReportPage, aRunThatWasStoppedSaysThatNothingIsLost) {
    const std::string page = unfinishedHtml("Doppel: <ada>", fullReport().filmAgain);
    EXPECT_NE(page.find("nothing is lost: the same command goes on where it was"), std::string::npos);
    EXPECT_NE(page.find("<h1>Doppel: &lt;ada&gt;</h1>"), std::string::npos);
    EXPECT_EQ(countOf(page, "<div class=card>"), 3u) << "what to film again is known already";
}

TEST(ReportPage, theAvatarIsAClickAway) {
    ReportData data = fullReport();
    EXPECT_NE(pageOf(data).find("href=\"avatar.glb\" download>Download</a>"), std::string::npos);
    EXPECT_NE(pageOf(data).find("doppel-viewer avatar.glb"), std::string::npos);
    data.avatarFile.clear();
    EXPECT_EQ(pageOf(data).find("Download"), std::string::npos) << "a page of doppel evaluate has no avatar beside it";
}

TEST(ReportPage, clipsShowEachPictureForItsShareOfTheRound) {
    const std::string page = pageOf(fullReport());
    EXPECT_NE(page.find("@keyframes clip0{0%{opacity:1}25.000%,100%{opacity:0}}"), std::string::npos);
    for (const char* begin : {"clip0 2.00s -2.000s", "clip0 2.00s -1.500s", "clip0 2.00s -1.000s", "clip0 2.00s -0.500s"})
        EXPECT_EQ(countOf(page, begin), 1u) << begin;
    EXPECT_NE(page.find("<figcaption>The avatar walking</figcaption>"), std::string::npos);
    EXPECT_EQ(countOf(page, "aria-label=\"The avatar walking\""), 1u) << "read out once, and not once a picture";
    EXPECT_EQ(countOf(page, "alt=\"The avatar walking\""), 0u);
    EXPECT_NE(page.find("prefers-reduced-motion"), std::string::npos);
    EXPECT_EQ(pageOf(bareReport()).find("In motion"), std::string::npos);
}

TEST(ReportPage, thePersonMovesWhereThereIsAModuleAndThePictureStaysWhereNot) {
    ReportData data = fullReport();
    EXPECT_EQ(pageOf(data).find("dpl-avatar"), std::string::npos);
    data.whyStill = "No <module>.";
    EXPECT_NE(pageOf(data).find("<figcaption class=soft>No &lt;module&gt;.</figcaption>"), std::string::npos);
    data.whyStill.clear();
    data.live = someLife();
    const std::string page = reportHtml(data);
    const size_t person = page.find("<figure id=person><div class=stage><img alt=\"the avatar, drawn as");
    ASSERT_NE(person, std::string::npos) << "the still picture is what the page holds";
    EXPECT_LT(person, page.find("<h1>"));
    EXPECT_NE(page.find("id=dpl-avatar>AQID</script>"), std::string::npos);
    EXPECT_GT(page.find("id=dpl-avatar>"), page.find("<details class=engineers>")) << "the first screen does not wait for it";
    EXPECT_NE(page.find("<script type=module>\nconsole.log('alive');</script>"), std::string::npos);
    data.portrait = {};
    EXPECT_EQ(reportHtml(data).find("dpl-avatar"), std::string::npos) << "nothing to bring to life";
}

TEST(ReportPage, aSliderComparesThePicturesThatThePageHoldsAnyway) {
    const std::string page = pageOf(fullReport());
    EXPECT_EQ(countOf(page, "<div class=\"pictures pairs\">"), 1u);
    EXPECT_EQ(countOf(page, "<div class=\"pictures differences\">"), 1u);
    EXPECT_NE(page.find("type: 'range'"), std::string::npos);
    EXPECT_EQ(pageOf(bareReport()).find("type: 'range'"), std::string::npos) << "nothing to compare";
}

// What layout_test.py measures in a browser, as far as the text shows it.
TEST(ReportPage, nothingCanBeWiderThanTheScreen) {
    const std::string page = pageOf(fullReport());
    EXPECT_NE(page.find("<meta name=viewport content=\"width=device-width,initial-scale=1\">"), std::string::npos);
    EXPECT_GE(countOf(page, "<table>"), 9u);
    EXPECT_EQ(countOf(page, "<table>"), countOf(page, "<div class=scroll><table>"));
    EXPECT_EQ(countOf(page, "</table>"), countOf(page, "</table></div>"));
    EXPECT_EQ(countOf(page, "<svg"), countOf(page, "<div class=scroll><svg"));
    EXPECT_EQ(countOf(page, "<div"), countOf(page, "</div>"));
    for (const char* rule : {".scroll{overflow-x:auto", "img{max-width:100%}", "white-space:pre-wrap;overflow-wrap:anywhere}",
                             "overflow-wrap:break-word}", "max-height:min(30rem,58vh)", "max-height:46vh"})
        EXPECT_NE(page.find(rule), std::string::npos) << rule;
    EXPECT_EQ(page.find("overflow:hidden"), std::string::npos) << "nothing may be cut off";
}

}  // namespace
}  // namespace dpl::test
