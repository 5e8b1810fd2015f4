// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/report/html_parts.h"

#include <cstdio>

namespace dpl {

const char* const kPageStyle = R"(
:root{color-scheme:light dark;--fg:#1f2937;--soft:#6b7280;--line:#e5e7eb;--card:#f9fafb;--accent:#2563eb;--good:#15803d;--bad:#b91c1c}
@media(prefers-color-scheme:dark){:root{--fg:#e5e7eb;--soft:#9ca3af;--line:#374151;--card:#1f2937;--accent:#60a5fa;--good:#4ade80;--bad:#f87171}
body{background:#111827}}
body{font:15px/1.5 system-ui,sans-serif;color:var(--fg);max-width:1080px;margin:1rem auto 2rem;padding:0 1rem;overflow-wrap:break-word}
h1{margin:0 0 .4rem;line-height:1.2}h2{margin-top:2.2rem;border-bottom:1px solid var(--line);padding-bottom:.2rem}
img{max-width:100%}.top{display:flex;gap:1.6rem;align-items:center}.top>*{min-width:0}.top figure{margin:0;flex:0 1 auto}
.top img{display:block;max-height:min(30rem,58vh);border-radius:.5rem;background:#fff}.top div{flex:1 1 0}
.word{font-size:1.6rem;font-weight:bold;margin:.2rem 0}.word.good{color:var(--good)}.word.again{color:var(--bad)}
.verdict{font-size:1.25rem;line-height:1.4;margin:.4rem 0}.soft{color:var(--soft)}.lines{white-space:pre-line}
@media(max-width:640px){.top{flex-direction:column;align-items:flex-start;gap:.6rem}.verdict{font-size:1.1rem}h1{font-size:1.3rem}
.top img{max-height:46vh}}
.scroll{overflow-x:auto;margin:.8rem 0}table{border-collapse:collapse;font-variant-numeric:tabular-nums}
th,td{padding:.25rem .8rem;border-bottom:1px solid var(--line);text-align:right}th:first-child,td:first-child{text-align:left}
td:first-child{min-width:8rem}td.text{text-align:left}td.reason{text-align:left;min-width:18rem}
pre{background:var(--card);padding:.8rem;white-space:pre-wrap;overflow-wrap:anywhere}
.big{display:flex;gap:1rem;flex-wrap:wrap}.big div{background:var(--card);border-radius:.5rem;padding:.7rem 1.1rem}.big b{display:block;font-size:1.7rem}
.pictures{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(320px,100%),1fr));gap:1rem}
.pictures figure{margin:0;background:var(--card);border-radius:.5rem;padding:.5rem}.pictures img{width:49%}
.links{display:flex;flex-wrap:wrap;gap:.6rem;align-items:flex-start;margin:.6rem 0}.links>*{margin:0}
.button,.links summary{display:inline-block;font-size:1rem;font-weight:bold;margin:0;padding:.45rem 1.1rem;border-radius:.5rem;
border:1px solid var(--accent);color:var(--accent);text-decoration:none}.button.first{background:var(--accent);color:#fff}
.links summary{list-style:none}.links details[open]{flex-basis:100%}
.cards{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(300px,100%),1fr));gap:1rem;margin:1rem 0}
.card{display:flex;gap:.8rem;background:var(--card);border-radius:.5rem;padding:.6rem}.card>*{min-width:0}.card p{margin:0 0 .3rem}
.card img{flex:none;width:104px;height:auto;align-self:flex-start;border-radius:.3rem;background:#fff}
.clips{display:flex;flex-wrap:wrap;gap:1rem}.clips figure{margin:0;background:var(--card);border-radius:.5rem;padding:.5rem}
.clip{display:grid}.clip img{grid-area:1/1;opacity:0;border-radius:.3rem}.clip img:first-child{opacity:1}
@media(prefers-reduced-motion:reduce){.clip img{animation:none!important}}
.maps{display:flex;flex-wrap:wrap;gap:1rem}summary{cursor:pointer;font-size:1.3rem;font-weight:bold;margin-top:2.2rem}
.plot text{font:11px system-ui;fill:var(--soft)}.plot text.title{font-size:13px;fill:var(--fg)}.plot .grid{stroke:var(--line)}
.bar{background:var(--accent);height:.8rem;display:inline-block;border-radius:2px}.met{color:var(--good)}.missed{color:var(--bad);font-weight:bold}
)";

namespace {

std::string image(const std::vector<uint8_t>& bytes, const char* type, const std::string& what, const std::string& style) {
    if (bytes.empty()) return {};
    const std::string text = escapeHtml(what);
    return "<img alt=\"" + text + (text.empty() ? "" : "\" title=\"" + text) + (style.empty() ? "" : "\" style=\"" + style) +
           "\" src=\"data:image/" + type + ";base64," + base64(bytes) + "\">";
}

}  // namespace

std::string pngImage(const std::vector<uint8_t>& png, const std::string& what) {
    return image(png, "png", what, {});
}
std::string jpegImage(const std::vector<uint8_t>& jpeg, const std::string& what, const std::string& style) {
    return image(jpeg, "jpeg", what, style);
}

std::string decimals(double value, int digits) {
    char text[48];
    std::snprintf(text, sizeof text, "%.*f", digits, value);
    return text;
}

std::string bulletList(const std::vector<std::string>& sentences) {
    std::string html = "<ul>";
    for (const std::string& sentence : sentences) html += "<li>" + escapeHtml(sentence) + "</li>";
    return html + "</ul>";
}

}  // namespace dpl
