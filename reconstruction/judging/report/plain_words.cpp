// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/report/plain_words.h"

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
constexpr Likeness kLikeness[] = {{24, "very close to the pictures"},
                                  {20, "like the pictures, but softer"},
                                  {16, "recognisable, but blurred or wrong in places"},
                                  {-1e9, "only roughly like the person"}};

const char* likenessOf(double maskedPsnrDb) {
    for (const Likeness& l : kLikeness)
        if (maskedPsnrDb >= l.fromDb) return l.words;
    return kLikeness[std::size(kLikeness) - 1].words;  // not a number
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

std::string verdictSentence(const ReportData& data) {
    const std::vector<HeldOutFrame>& judges = data.frames.empty() ? data.validation : data.frames;
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
