// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/page/live_page.h"

#include "reconstruction/output/page/html_text.h"

namespace dpl {
namespace {

constexpr const char* kShareStyle = R"(
:root{color-scheme:light dark;--accent:#2563eb}
body{font:16px/1.5 system-ui,sans-serif;margin:0;padding:1rem;display:flex;flex-direction:column;align-items:center;overflow-wrap:anywhere}
h1{font-size:1.4rem;margin:.6rem 0 0;text-align:center}p{margin:.2rem 0;font-size:.85rem;opacity:.75;text-align:center;max-width:34rem}
#person .stage{height:min(70vh,125vw)}#person .moves{justify-content:center}
)";

std::string dataBlock(const char* id, std::span<const uint8_t> bytes) {
    return std::string("<script type=\"application/octet-stream\" id=") + id + ">" + base64(bytes) + "</script>\n";
}

}  // namespace

std::string liveFigure(const std::string& stillImage) {
    return "<figure id=person><div class=stage>" + stillImage + "</div></figure>";
}

std::string liveParts(const WebModule& module, std::span<const uint8_t> avatar) {
    return dataBlock("dpl-avatar", avatar) + dataBlock("dpl-module", module.packed) + "<script type=module>\n" + module.script +
           "</script>\n";
}

std::string sharePage(const SharedPerson& person, const WebModule& module) {
    const std::string name = escapeHtml(person.name), licence = escapeHtml(person.licence.empty() ? "not stated" : person.licence);
    const std::string still =
        person.still.empty() ? "" : "<img alt=\"" + name + "\" src=\"data:image/jpeg;base64," + base64(person.still) + "\">";
    return "<!doctype html><html lang=en><meta charset=utf-8><meta name=viewport content=\"width=device-width,initial-scale=1\"><title>" +
           name + "</title><meta name=\"dcterms.title\" content=\"" + name + "\"><meta name=\"dcterms.license\" content=\"" + licence +
           "\"><meta name=generator content=\"doppel share\"><style>" + module.style + kShareStyle + "</style>\n" + liveFigure(still) +
           "<h1>" + name + "</h1><p>Licence: " + licence +
           "</p><p>Drag to turn, wheel or two fingers to zoom; with the keyboard, arrow keys, + and −.</p>\n<noscript><p>Scripts are off "
           "here, so the person stands still.</p></noscript>\n" +
           liveParts(module, person.avatar) + "</html>\n";
}

}  // namespace dpl
