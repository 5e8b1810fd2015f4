// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/capture_map.h"

#include <algorithm>
#include <cmath>

namespace dpl {
namespace {

constexpr const char* kSideNames[kCaptureSides] = {"front", "left", "back", "right"};
constexpr float kStepsAnOctave = 16;
constexpr size_t kBytesASide = 3;

uint8_t codeOf(float metres) {
    if (!(metres > 0)) return 0;
    const float steps = std::round(kStepsAnOctave * std::log2(metres / kLeastCaptureM));
    return uint8_t(1 + std::clamp(steps, 0.0f, 254.0f));
}

float metresOf(uint8_t code) {
    return code == 0 ? 0 : kLeastCaptureM * std::exp2(float(code - 1) / kStepsAnOctave);
}

}  // namespace

Status checkCaptureMap(const CaptureMapData& map, size_t jointCount) {
    if (map.sides.empty()) return {};
    if (map.sides.size() != jointCount * kCaptureSides)
        return fail(Code::InvalidArgument, "the capture map has {} sides for {} joints, {} a joint are needed", map.sides.size(),
                    jointCount, kCaptureSides);
    for (size_t i = 0; i < map.sides.size(); ++i) {
        const CaptureSide& side = map.sides[i];
        const auto bad = [&](const char* what) {
            return fail(Code::InvalidArgument, "the capture map of joint {}, {}: {}", i / kCaptureSides, kSideNames[i % kCaptureSides],
                        what);
        };
        if (!(side.pixelM >= 0 && side.detailM >= 0) || !std::isfinite(side.pixelM) || !std::isfinite(side.detailM))
            return bad("a size is negative or not finite");
        if (side.detailM < side.pixelM || (side.detailM > 0) != (side.pixelM > 0)) return bad("the finest detail is smaller than a pixel");
        if (side.views > 0 && !(side.detailM > 0)) return bad("it is not seen, but in pictures");
    }
    return {};
}

std::vector<uint8_t> encodeCaptureMap(const CaptureMapData& map) {
    std::vector<uint8_t> out;
    out.reserve(map.sides.size() * kBytesASide);
    for (const CaptureSide& side : map.sides)
        out.insert(out.end(), {codeOf(side.pixelM), codeOf(side.detailM), uint8_t(std::min(side.views, 255u))});
    return out;
}

Result<CaptureMapData> decodeCaptureMap(std::span<const uint8_t> bytes, size_t jointCount) {
    if (bytes.size() != jointCount * kCaptureSides * kBytesASide)
        return fail(Code::CorruptData, "a capture map of {} bytes for {} joints, {} a joint are needed", bytes.size(), jointCount,
                    kCaptureSides * kBytesASide);
    CaptureMapData map;
    map.sides.reserve(bytes.size() / kBytesASide);
    for (size_t i = 0; i < bytes.size(); i += kBytesASide) map.sides.push_back({metresOf(bytes[i]), metresOf(bytes[i + 1]), bytes[i + 2]});
    return map;
}

}  // namespace dpl
