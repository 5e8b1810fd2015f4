// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/file_kind.h"

#include <algorithm>
#include <cctype>
#include <string>

namespace dpl {
namespace {

std::string lower(std::string_view text) {
    std::string out(text);
    std::transform(out.begin(), out.end(), out.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    return out;
}

/** The JSON of a .glb: its first chunk. Empty if the file ends before its end: what is missing may be the name of an extension. */
std::string_view jsonOfGlb(std::string_view text) {
    constexpr size_t kJsonAt = 20;
    if (text.size() < kJsonAt) return {};
    uint32_t bytes = 0;
    for (int i = 3; i >= 0; --i) bytes = bytes << 8 | uint8_t(text[12 + size_t(i)]);
    return bytes <= text.size() - kJsonAt ? text.substr(kJsonAt, bytes) : std::string_view();
}

}  // namespace

FileKind fileKindOf(std::span<const uint8_t> bytes, std::string_view name) {
    constexpr size_t kMostBytes = size_t(64) << 20;
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), std::min(bytes.size(), kMostBytes));
    if (text.starts_with("\x1f\x8b") || text.starts_with("NGSP") || text.starts_with("ply")) return FileKind::Subject;
    if (text.starts_with("glTF")) {
        const std::string_view json = jsonOfGlb(text);
        const auto names = [&](std::string_view word) { return json.find(word) != json.npos; };
        const bool splats = names("\"DPL_gaussian_avatar\"") || names("\"KHR_gaussian_splatting\"");
        return !splats && names("\"animations\"") ? FileKind::Motion : FileKind::Subject;
    }
    const size_t word = std::min(text.find_first_not_of(" \t\r\n"), text.size());
    const std::string begin = lower(text.substr(word, 9)), ending = lower(name);
    if (begin == "hierarchy" || begin.starts_with('{') || ending.ends_with(".bvh") || ending.ends_with(".gltf")) return FileKind::Motion;
    return FileKind::Unknown;
}

}  // namespace dpl
