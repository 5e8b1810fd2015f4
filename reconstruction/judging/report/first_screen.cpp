// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/report/first_screen.h"

#include <algorithm>
#include <cctype>

#include "reconstruction/judging/report/html_parts.h"
#include "reconstruction/judging/report/plain_words.h"
#include "reconstruction/output/page/live_page.h"

namespace dpl {
namespace {

constexpr size_t kCards = 3;

const char* classOf(Worth worth) {
    return worth == Worth::Good ? "good" : worth == Worth::Usable ? "usable" : "again";
}

/** How to see the avatar, and the file itself. A browser cannot show it, so *Open* says what can. */
void addLinks(std::string& html, const std::string& file) {
    if (file.empty()) return;
    const std::string name = escapeHtml(file);
    html +=
        "<div class=links><details class=open><summary>Open</summary><p>On the computer where this page lies, in its folder:</p>"
        "<pre>doppel-viewer " +
        name + "</pre><p>For other programs, as a mesh:</p><pre>doppel export " + name +
        " --mesh -o mesh.glb</pre></details><a class=\"button first\" href=\"" + name + "\" download>Download</a></div>";
}

/** What to do in bold; what the sentence says behind its first colon is why. */
std::string cardText(const std::string& sentence) {
    const size_t colon = sentence.find(": ");
    if (colon == std::string::npos) return "<p><b>" + escapeHtml(sentence) + "</b></p>";
    std::string why = sentence.substr(colon + 2);
    if (!why.empty()) why[0] = char(std::toupper(uint8_t(why[0])));
    return "<p><b>" + escapeHtml(sentence.substr(0, colon)) + "</b></p><p class=soft>" + escapeHtml(why) + "</p>";
}

}  // namespace

void addTop(std::string& html, const ReportData& data) {
    html += "<header class=top>";
    if (!data.portrait.png.empty()) {
        const std::string still =
            pngImage(data.portrait.png, "the avatar, drawn as the camera of " + data.portrait.frame + " saw the person");
        const std::string why = data.whyStill.empty() ? "" : "<figcaption class=soft>" + escapeHtml(data.whyStill) + "</figcaption>";
        html += data.live ? liveFigure(still) : "<figure>" + still + why + "</figure>";
    }
    const Worth worth = worthOf(data);
    html += "<div><h1>" + escapeHtml(data.title) + "</h1><p class=\"word " + classOf(worth) + "\">" + wordOf(worth) +
            "</p><p class=verdict>" + escapeHtml(verdictSentence(data)) + "</p>";
    addLinks(html, data.avatarFile);
    if (const std::string draft = draftSentence(data); !draft.empty()) html += "<p class=soft>" + escapeHtml(draft) + "</p>";
    html += "</div></header>";
}

void addAdvice(std::string& html, const FilmAgainSection& section) {
    if (section.advice.empty() && section.warnings.empty()) return;
    html += "<h2>What to film again</h2>";
    if (section.cards.empty()) html += "<p class=lines>" + escapeHtml(section.advice) + "</p>";
    const size_t shown = std::min(kCards, section.cards.size());
    if (shown > 0) html += "<p>The most helpful first:</p><div class=cards>";
    for (size_t i = 0; i < shown; ++i)
        html += "<div class=card>" + jpegImage(section.cards[i].jpeg, "what the shot looks like") + "<div>" +
                cardText(section.cards[i].sentence) + "</div></div>";
    if (shown > 0) html += "</div>";
    if (section.cards.size() > shown) {
        std::vector<std::string> more;
        for (size_t i = shown; i < section.cards.size(); ++i) more.push_back(section.cards[i].sentence);
        html += "<p>Then:</p>" + bulletList(more);
    }
    if (!section.warnings.empty()) html += "<p>The check of the pictures warns:</p>" + bulletList(section.warnings);
}

void addClips(std::string& html, const std::vector<ReportClip>& clips) {
    if (clips.empty()) return;
    // All pictures of a clip lie on one another. Each is shown for its share of the round, by an animation that begins at its turn.
    std::string figures, keyframes;
    for (size_t c = 0; c < clips.size(); ++c) {
        const ReportClip& clip = clips[c];
        const size_t count = clip.jpegs.size();
        keyframes += formatText("@keyframes clip{}{0%{opacity:1}{}%,100%{opacity:0}}", c, decimals(100.0 / double(count), 3));
        figures += "<figure><div class=clip role=img aria-label=\"" + escapeHtml(clip.title) + "\">";
        for (size_t i = 0; i < count; ++i)
            figures += jpegImage(clip.jpegs[i], "",
                                 formatText("animation:clip{} {}s {}s step-end infinite", c, decimals(clip.seconds, 2),
                                            decimals(clip.seconds * (double(i) / double(count) - 1), 3)));
        figures += "</div><figcaption>" + escapeHtml(clip.title) + "</figcaption></figure>";
    }
    html += "<h2>In motion</h2><style>" + keyframes + "</style><div class=clips>" + figures + "</div>";
}

}  // namespace dpl
