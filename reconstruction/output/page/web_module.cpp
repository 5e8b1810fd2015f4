// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/page/web_module.h"

#include <algorithm>

#include "sdk/core/files.h"

namespace dpl {
namespace {

constexpr uint64_t kMostBytes = 16 << 20;
constexpr size_t kLzmaHeaderBytes = 18;
constexpr uint8_t kLargestLzmaProperties = 9 * 5 * 5 - 1;

Result<std::vector<uint8_t>> readPart(const std::filesystem::path& file) {
    auto bytes = readFile(file, kMostBytes);
    if (!bytes && bytes.error().code == Code::NotFound)
        return fail(Code::NotFound, "there is no {}, a part of the web module; {}", file.string(), kHowToGetModule);
    if (bytes && bytes->empty()) return fail(Code::CorruptData, "{} is empty; {}", file.string(), kHowToGetModule);
    return bytes;
}

/** A text that stands inside an element of HTML, which it must not end. */
Result<std::string> readText(const std::filesystem::path& file, const char* element) {
    DPL_TRY(const auto bytes, readPart(file));
    std::string text(bytes.begin(), bytes.end());
    std::string small = text;
    std::transform(small.begin(), small.end(), small.begin(),
                   [](unsigned char c) { return c >= 'A' && c <= 'Z' ? char(c + 32) : char(c); });
    if (small.find(std::string("</") + element) != std::string::npos || small.find("<!--") != std::string::npos)
        return fail(Code::CorruptData, "{} cannot stand inside a page, because it ends its element; {}", file.string(), kHowToGetModule);
    return text;
}

}  // namespace

Result<WebModule> readWebModule(const std::filesystem::path& folder) {
    WebModule module;
    const std::filesystem::path packed = folder / "page" / "doppel.wasm.lzma";
    DPL_TRY(module.packed, readPart(packed));
    if (module.packed.size() < kLzmaHeaderBytes || module.packed[0] > kLargestLzmaProperties)
        return fail(Code::CorruptData, "{} is no .lzma file; {}", packed.string(), kHowToGetModule);
    DPL_TRY(module.script, readText(folder / "page" / "live-bundle.js", "script"));
    DPL_TRY(module.style, readText(folder / "page" / "live.css", "style"));
    return module;
}

}  // namespace dpl
