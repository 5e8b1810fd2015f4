// SPDX-License-Identifier: Apache-2.0
// Reads what EXT_meshopt_compression holds, as a viewer does.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include "tests/unit/format/glb_parts.h"

namespace dpl::test {

/** The same .glb with plain views. Checks what the extension demands of the file. */
inline std::vector<uint8_t> withoutMeshopt(std::span<const uint8_t> glb) {
    constexpr const char* kExtension = "EXT_meshopt_compression";
    GlbParts parts = split(glb);
    nlohmann::json& root = parts.json;
    const auto lists = [&](const char* list) { return std::count(root[list].begin(), root[list].end(), nlohmann::json(kExtension)) == 1; };
    EXPECT_TRUE(lists("extensionsUsed") && lists("extensionsRequired"));
    EXPECT_EQ(root["buffers"].size(), 2u);
    EXPECT_EQ(root["buffers"][0]["byteLength"], parts.bin.size());
    EXPECT_TRUE(root["buffers"][1]["extensions"][kExtension]["fallback"].get<bool>());
    EXPECT_FALSE(root["buffers"][1].contains("uri"));
    std::vector<uint8_t> bin;
    for (nlohmann::json& view : root["bufferViews"]) {
        std::vector<uint8_t> bytes(view["byteLength"].get<size_t>());
        if (view["buffer"] == 0) {
            EXPECT_FALSE(view.contains("extensions"));
            const auto plain = std::span(parts.bin).subspan(view["byteOffset"].get<size_t>(), bytes.size());
            bytes.assign(plain.begin(), plain.end());
        } else {
            EXPECT_LE(view["byteOffset"].get<size_t>() + bytes.size(), root["buffers"][1]["byteLength"].get<size_t>());
            const nlohmann::json code = view["extensions"][kExtension];
            const size_t count = code["count"], stride = code["byteStride"];
            EXPECT_EQ(count * stride, bytes.size());
            EXPECT_EQ(code["buffer"], 0);
            const auto coded = std::span(parts.bin).subspan(code["byteOffset"].get<size_t>(), code["byteLength"].get<size_t>());
            EXPECT_LT(coded.size(), bytes.size());
            const std::string mode = code["mode"];
            EXPECT_EQ(coded[0], mode == "ATTRIBUTES" ? 0xa0 : mode == "TRIANGLES" ? 0xe1 : 0xd1) << "the extension's versions";
            const int failed = mode == "ATTRIBUTES"  ? meshopt_decodeVertexBuffer(bytes.data(), count, stride, coded.data(), coded.size())
                               : mode == "TRIANGLES" ? meshopt_decodeIndexBuffer(bytes.data(), count, stride, coded.data(), coded.size())
                                                     : meshopt_decodeIndexSequence(bytes.data(), count, stride, coded.data(), coded.size());
            EXPECT_EQ(failed, 0) << mode;
            if (code.contains("filter")) {
                EXPECT_EQ(code["filter"], "EXPONENTIAL");
                meshopt_decodeFilterExp(bytes.data(), count, stride);
            }
        }
        bin.resize((bin.size() + 3) / 4 * 4);
        view["buffer"] = 0, view["byteOffset"] = bin.size();
        view.erase("extensions");
        bin.insert(bin.end(), bytes.begin(), bytes.end());
    }
    bin.resize((bin.size() + 3) / 4 * 4);
    root["buffers"] = nlohmann::json::array({{{"byteLength", bin.size()}}});
    root.erase("extensionsRequired");
    parts.bin = std::move(bin);
    return parts.bytes();
}

}  // namespace dpl::test
