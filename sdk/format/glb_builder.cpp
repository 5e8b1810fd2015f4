// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/glb_builder.h"

#include "sdk/core/writer.h"

namespace dpl {

std::vector<uint8_t> glbOf(std::string json, std::span<const uint8_t> bin) {
    constexpr uint32_t kMagic = 0x46546C67, kVersion = 2, kJson = 0x4E4F534A, kBin = 0x004E4942;
    while (json.size() % 4) json.push_back(' ');
    const uint32_t paddedBytes = uint32_t((bin.size() + 3) / 4 * 4), binBytes = bin.empty() ? 0 : 8 + paddedBytes;
    Writer out;
    out.value(kMagic), out.value(kVersion), out.value(uint32_t(12 + 8 + json.size() + binBytes));
    out.value(uint32_t(json.size())), out.value(kJson);
    out.append({reinterpret_cast<const uint8_t*>(json.data()), json.size()});
    if (binBytes) {
        out.value(paddedBytes), out.value(kBin);
        out.append(bin);
        out.alignTo(4);
    }
    return out.finish();
}

uint32_t GlbBuilder::addView(std::span<const uint8_t> bytes, int target) {
    while (bin_.size() % 4) bin_.push_back(0);
    Json view = {{"buffer", 0}, {"byteOffset", bin_.size()}, {"byteLength", bytes.size()}};
    if (target) view["target"] = target;
    bin_.insert(bin_.end(), bytes.begin(), bytes.end());
    views_.push_back(std::move(view));
    return uint32_t(views_.size() - 1);
}

Json& GlbBuilder::addAccessor(int64_t view, int component, const char* type, size_t count, bool normalized) {
    Json accessor = {{"componentType", component}, {"type", type}, {"count", count}};
    if (view >= 0) accessor["bufferView"] = view;
    if (normalized) accessor["normalized"] = true;
    accessors_.push_back(std::move(accessor));
    return accessors_.back();
}

std::string GlbBuilder::takeJson() {
    while (bin_.size() % 4) bin_.push_back(0);
    if (!bin_.empty()) root["buffers"] = Json::array({{{"byteLength", bin_.size()}}});
    if (!views_.empty()) root["bufferViews"] = std::move(views_);
    if (!accessors_.empty()) root["accessors"] = std::move(accessors_);
    std::string json = root.dump(-1, ' ', false, Json::error_handler_t::replace);
    while (json.size() % 4) json.push_back(' ');
    return json;
}

}  // namespace dpl
