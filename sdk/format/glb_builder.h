// SPDX-License-Identifier: Apache-2.0
// Builds a .glb: collects views and accessors as JSON and their bytes in the binary chunk. Internal. Only .cpp files include it, because
// the JSON header is slow to compile.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "sdk/core/result.h"

namespace dpl {

using Json = nlohmann::json;

constexpr int kGltfU8 = 5121, kGltfU16 = 5123, kGltfU32 = 5125, kGltfF32 = 5126;
constexpr int kGltfVertices = 34962, kGltfIndices = 34963;  // buffer view targets

/** A .glb of its JSON and its binary chunk. */
std::vector<uint8_t> glbOf(std::string json, std::span<const uint8_t> bin);

class GlbBuilder {
public:
    Json root;  // finish() adds buffers, bufferViews and accessors

    /** Appends bytes at the next multiple of 4 and returns the index of their view. target: kGltfVertices, kGltfIndices or 0 for none. */
    uint32_t addView(std::span<const uint8_t> bytes, int target = 0);
    template <class T>
    uint32_t addView(const std::vector<T>& values, int target = 0) {
        return addView(std::span(reinterpret_cast<const uint8_t*>(values.data()), values.size() * sizeof(T)), target);
    }
    /** Adds an accessor over a whole view; view -1: an extension supplies the data. The caller may add fields such as min and max. */
    Json& addAccessor(int64_t view, int component, const char* type, size_t count, bool normalized = false);
    uint32_t lastAccessor() const { return uint32_t(accessors_.size() - 1); }
    const std::vector<uint8_t>& bin() const { return bin_; }

    /** The finished file. patchJson may change bytes of the JSON text but not its length; the content hash is written this way. */
    template <class Patch>
    std::vector<uint8_t> finish(Patch patchJson) {
        std::string json = takeJson();
        patchJson(json, std::span<const uint8_t>(bin_));
        return glbOf(std::move(json), bin_);
    }

private:
    std::string takeJson();

    Json views_ = Json::array(), accessors_ = Json::array();
    std::vector<uint8_t> bin_;
};

}  // namespace dpl
