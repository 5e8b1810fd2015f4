// SPDX-License-Identifier: Apache-2.0
// Puts a .glb together: JSON tables and the binary chunk grow side by side. Internal; included by .cpp files only (heavy JSON header).
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "sdk/core/result.h"

namespace dpl {

using Json = nlohmann::json;

constexpr int kGltfU8 = 5121, kGltfU16 = 5123, kGltfU32 = 5125, kGltfF32 = 5126;
constexpr int kGltfVertices = 34962, kGltfIndices = 34963;  // buffer view targets

class GlbBuilder {
public:
    Json root;  // everything except buffers, bufferViews and accessors, which finish() adds

    /** Appends bytes at a multiple of 4; target 0: none. Returns the view. */
    uint32_t addView(std::span<const uint8_t> bytes, int target = 0);
    template <class T>
    uint32_t addView(const std::vector<T>& values, int target = 0) {
        return addView(std::span(reinterpret_cast<const uint8_t*>(values.data()), values.size() * sizeof(T)), target);
    }
    /** An accessor over a whole view; view -1: filled by an extension. Fields like min and max can be added to the result. */
    Json& addAccessor(int64_t view, int component, const char* type, size_t count, bool normalized = false);
    uint32_t lastAccessor() const { return uint32_t(accessors_.size() - 1); }
    const std::vector<uint8_t>& bin() const { return bin_; }

    /** The finished file. `patchJson` may change bytes of the JSON chunk, not its length (content hash). */
    template <class Patch>
    std::vector<uint8_t> finish(Patch patchJson) {
        std::string json = takeJson();
        patchJson(json, std::span<const uint8_t>(bin_));
        return wrap(json);
    }

private:
    std::string takeJson();
    std::vector<uint8_t> wrap(const std::string& json) const;

    Json views_ = Json::array(), accessors_ = Json::array();
    std::vector<uint8_t> bin_;
};

}  // namespace dpl
