// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/report/plain_words.h"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <string_view>
#include <utility>

#include "sdk/core/result.h"

namespace dpl {
namespace {

/** What a mean masked PSNR looks like. Judged by eye on drafts between 16 and 25 dB, drawn beside their pictures. */
struct Likeness {
    double fromDb;
    const char* words;
};
constexpr double kLikeDb = 20, kRecognisableDb = 16;
constexpr Likeness kLikeness[] = {{24, "very close to the pictures"},
                                  {kLikeDb, "like the pictures, but softer"},
                                  {kRecognisableDb, "recognisable, but blurred or wrong in places"},
                                  {-1e9, "only roughly like the person"}};

const char* likenessOf(double maskedPsnrDb) {
    for (const Likeness& l : kLikeness)
        if (maskedPsnrDb >= l.fromDb) return l.words;
    return kLikeness[std::size(kLikeness) - 1].words;  // not a number
}

// Shares of a place that no still picture shows. A quarter is a strip that can be smeared; of a half, that side was not filmed.
constexpr double kSeenEnough = 0.25, kNotFilmed = 0.5;
constexpr std::string_view kTrunkAndHead[] = {"face", "head", "chest", "back"};

/** The pictures that the avatar was not made from. */
const std::vector<HeldOutFrame>& judgesOf(const ReportData& data) {
    return data.frames.empty() ? data.validation : data.frames;
}

/** What a part of the evidence is to the eye; the part's own name follows in brackets, for the table. */
std::string plainName(const std::string& part) {
    constexpr std::string_view kGarment = "garment layer: ";
    constexpr std::pair<std::string_view, const char*> kNames[] = {{"garment layers", "clothes as layers of their own"},
                                                                   {"pose-dependent offsets", "a surface that follows the pose"},
                                                                   {"pose-dependent light", "light that follows the pose"},
                                                                   {"view-dependent colour", "gloss"}};
    if (part.starts_with(kGarment)) return part.substr(kGarment.size()) + " as a layer of its own";
    for (const auto& [begin, name] : kNames)
        if (part.starts_with(begin)) return name + (" (" + part + ")");
    return part;
}

}  // namespace

const char* const kWorthRule =
    "Good: on the pictures that the avatar was not made from, standing still and moving each reach a mean masked PSNR of 20 dB, and no "
    "still-picture gap hides more than a quarter of any place of the body. Film again: one of them stays below 16 dB, or more than half of "
    "the face, the head, the chest or the back is in no still picture. Usable: all else, and an avatar without pictures to judge it by.";

Worth worthOf(const ReportData& data) {
    Worth worth = Worth::Good;
    const auto atMost = [&worth](Worth other) { worth = std::max(worth, other); };  // the enumeration goes from good to bad
    if (judgesOf(data).empty()) atMost(Worth::Usable);
    for (const FrameKind kind : {FrameKind::StaticFull, FrameKind::Dynamic})
        if (const auto mean = meanScore(judgesOf(data), kind, &HeldOutFrame::withPoseFit)) {
            if (!(mean->maskedPsnrDb >= kLikeDb)) atMost(Worth::Usable);
            if (!(mean->maskedPsnrDb >= kRecognisableDb)) atMost(Worth::FilmAgain);
        }
    for (const MapRow& row : data.filmAgain.rows) {
        if (row.unseenShare > kSeenEnough) atMost(Worth::Usable);
        if (row.unseenShare > kNotFilmed && std::ranges::find(kTrunkAndHead, row.key) != std::end(kTrunkAndHead)) atMost(Worth::FilmAgain);
    }
    return worth;
}

const char* wordOf(Worth worth) {
    return worth == Worth::Good ? "Good" : worth == Worth::Usable ? "Usable" : "Film again";
}

std::string verdictSentence(const ReportData& data) {
    const std::vector<HeldOutFrame>& judges = judgesOf(data);
    if (judges.empty()) return "No picture was kept back to judge the avatar by: look at it yourself before you use it.";
    struct Said {
        std::string when, words;
    };
    std::vector<Said> said;
    for (const auto& [kind, when] :
         {std::pair{FrameKind::StaticFull, "standing still"}, {FrameKind::Dynamic, "moving"}, {FrameKind::StaticCloseup, "from near"}}) {
        const auto mean = meanScore(judges, kind, &HeldOutFrame::withPoseFit);
        if (!mean) continue;
        const std::string words = likenessOf(mean->maskedPsnrDb);
        if (!said.empty() && said.back().words == words)
            said.back().when += std::string(" and ") + when;
        else
            said.push_back({when, words});
    }
    std::string text;
    for (const Said& s : said)
        text += (text.empty() ? "" : "; ") + s.when + (text.empty() ? ", the avatar looks " : ", it looks ") + s.words;
    if (!text.empty()) text[0] = char(std::toupper(text[0]));
    return text + formatText(" (judged by {} picture{} that it was not made from).", judges.size(), judges.size() == 1 ? "" : "s");
}

std::string draftSentence(const ReportData& data) {
    if (data.length.steps >= data.length.standardSteps) return "";
    return formatText("This is a draft: it was trained for {} steps. The preset standard trains for {} and makes a finer avatar.",
                      data.length.steps, data.length.standardSteps);
}

std::vector<std::string> leftOut(const std::vector<EvidenceData>& evidence) {
    std::vector<std::string> sentences;
    for (const EvidenceData& row : evidence) {
        if (row.kept) continue;
        const std::string why = row.gainDb == 0  ? row.reason
                                : row.gainDb < 0 ? "the pictures were better without it"
                                                 : "the pictures were better with it, but too little for its size in the file";
        sentences.push_back(plainName(row.part) + ": " + why);
    }
    return sentences;
}

}  // namespace dpl
