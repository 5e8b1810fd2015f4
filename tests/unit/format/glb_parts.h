// SPDX-License-Identifier: Apache-2.0
// Splits a .glb into its parts and joins them again, so that tests can damage one part at a time.
#pragma once

#include <cstring>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace dpl::test {

struct GlbParts {
    nlohmann::json json;
    std::vector<uint8_t> bin;

    std::vector<uint8_t> bytes() const { return join(json.dump()); }

    std::vector<uint8_t> join(std::string text) const {
        while (text.size() % 4) text.push_back(' ');
        std::vector<uint8_t> out;
        auto word = [&](size_t value) {
            const uint32_t w = uint32_t(value);
            const auto* raw = reinterpret_cast<const uint8_t*>(&w);
            out.insert(out.end(), raw, raw + 4);
        };
        word(0x46546C67), word(2), word(20 + text.size() + (bin.empty() ? 0 : 8 + bin.size()));
        word(text.size()), word(0x4E4F534A);
        out.insert(out.end(), text.begin(), text.end());
        if (!bin.empty()) {
            word(bin.size()), word(0x004E4942);
            out.insert(out.end(), bin.begin(), bin.end());
        }
        return out;
    }

    /** Bytes of the buffer view of stream `name` of the extension DPL_gaussian_avatar. */
    std::span<uint8_t> stream(const char* name) {
        return view(json["extensions"]["DPL_gaussian_avatar"]["splats"]["streams"][name].get<size_t>());
    }
    std::span<uint8_t> correctiveStream(const char* name) {
        return view(json["extensions"]["DPL_gaussian_avatar"]["poseCorrectives"]["streams"][name].get<size_t>());
    }
    std::span<uint8_t> view(size_t index) {
        const auto& v = json["bufferViews"][index];
        return std::span(bin).subspan(v.value("byteOffset", size_t(0)), v["byteLength"].get<size_t>());
    }
    std::span<uint8_t> accessor(size_t index) { return view(json["accessors"][index]["bufferView"].get<size_t>()); }
};

inline GlbParts split(std::span<const uint8_t> bytes) {
    uint32_t jsonBytes;
    std::memcpy(&jsonBytes, bytes.data() + 12, 4);
    GlbParts parts;
    parts.json = nlohmann::json::parse(bytes.begin() + 20, bytes.begin() + 20 + jsonBytes);
    if (bytes.size() > 28 + jsonBytes) parts.bin.assign(bytes.begin() + 28 + jsonBytes, bytes.end());
    return parts;
}

}  // namespace dpl::test
