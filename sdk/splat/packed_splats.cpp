// SPDX-License-Identifier: Apache-2.0
#include "sdk/splat/packed_splats.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <new>

#include "sdk/core/log.h"
#include "sdk/splat/packed_layout.h"

namespace dpl {
namespace {

constexpr size_t kAlignment = 64;

void packSh(const float* sh, uint32_t floats, uint32_t lane, float* fields) {
    for (uint32_t k = 0; k < floats; ++k) fields[k * kGroupSplats + lane] = sh[k];
}

template <class Splats, class... Order>
float* packAll(const Splats& splats, bool bound, const Order&... order) {
    const size_t groups = groupCount(usableCount(splats)), floats = size_t(groupFields(bound, splats.shDegree)) * kGroupSplats;
    if (groups == 0) return nullptr;
    float* data = static_cast<float*>(::operator new[](groups* floats * sizeof(float), std::align_val_t(kAlignment)));
    for (size_t g = 0; g < groups; ++g) packGroup(splats, uint32_t(g * kGroupSplats), data + g * floats, order...);
    return data;
}

uint32_t countOrNone(bool complete, uint32_t count) {
    if (complete) return count;
    log(LogLevel::Error, "splat arrays differ in length, or their SH degree is above {}: nothing is drawn", kMaxShDegree);
    return 0;
}

}  // namespace

uint32_t usableCount(const BoundSplatView& s) {
    const size_t n = s.count();
    return countOrNone(s.shDegree <= kMaxShDegree && s.uv.size() == n && s.phi.size() == n && s.scaleM.size() == n &&
                           s.opacity.size() == n && s.flags.size() == n && s.sh.size() == n * shCoefficientCount(s.shDegree) * 3,
                       s.count());
}

uint32_t usableCount(const StaticSplatData& s) {
    const size_t n = s.count();
    return countOrNone(s.shDegree <= kMaxShDegree && s.rotation.size() == n && s.scaleM.size() == n && s.opacity.size() == n &&
                           s.sh.size() == n * shCoefficientCount(s.shDegree) * 3,
                       s.count());
}

void PackedSplats::Free::operator()(float* p) const {
    ::operator delete[](p, std::align_val_t(kAlignment));
}

PackedSplats::PackedSplats(const BoundSplatView& splats)
    : data_(packAll(splats, true)), count_(data_ ? splats.count() : 0), shDegree_(splats.shDegree), bound_(true) {}

PackedSplats::PackedSplats(const StaticSplatData& splats, std::span<const uint32_t> order)
    : data_(packAll(splats, false, order)), count_(data_ ? splats.count() : 0), shDegree_(splats.shDegree), bound_(false) {}

uint64_t PackedSplats::bytes() const {
    return groupCount(count_) * groupFields(bound_, shDegree_) * kGroupSplats * sizeof(float);
}

void packGroup(const BoundSplatView& splats, uint32_t first, float* out) {
    using namespace bound_field;
    const uint32_t shFloats = shCoefficientCount(splats.shDegree) * 3, lanes = std::min(kGroupSplats, splats.count() - first);
    if (lanes < kGroupSplats) std::memset(out, 0, groupFields(true, splats.shDegree) * kGroupSplats * sizeof(float));
    const auto put = [&](uint32_t field, uint32_t lane, float value) { out[field * kGroupSplats + lane] = value; };
    for (uint32_t lane = 0; lane < lanes; ++lane) {
        const uint32_t i = first + lane;
        const auto a = Formulas<float>::planeAxes(std::cos(splats.phi[i]), std::sin(splats.phi[i]), splats.scaleM[i].x, splats.scaleM[i].y);
        put(kU, lane, splats.uv[i].x), put(kV, lane, splats.uv[i].y);
        put(kAxis10, lane, a.a10), put(kAxis11, lane, a.a11), put(kAxis20, lane, a.a20), put(kAxis21, lane, a.a21);
        put(kOpacity, lane, splats.opacity[i]);
        put(kSingleFace, lane, splats.flags[i] & kSplatSingleFace ? 1.f : 0.f);
        put(kCloth, lane, splats.flags[i] & kSplatCloth ? 1.f : 0.f);
        put(kTriangle, lane, std::bit_cast<float>(splats.triangle[i]));
        packSh(splats.sh.data() + size_t(i) * shFloats, shFloats, lane, out + kSh * kGroupSplats);
    }
}

void packGroup(const StaticSplatData& splats, uint32_t first, float* out, std::span<const uint32_t> order) {
    using namespace static_field;
    const uint32_t shFloats = shCoefficientCount(splats.shDegree) * 3, lanes = std::min(kGroupSplats, splats.count() - first);
    if (lanes < kGroupSplats) std::memset(out, 0, groupFields(false, splats.shDegree) * kGroupSplats * sizeof(float));
    for (uint32_t lane = 0; lane < lanes; ++lane) {
        const uint32_t i = order.empty() ? first + lane : order[first + lane];
        const Mat3f rotation = glm::mat3_cast(splats.rotation[i]);
        for (uint32_t k = 0; k < 3; ++k) {
            out[(kPosition + k) * kGroupSplats + lane] = splats.position[i][int(k)];
            for (uint32_t r = 0; r < 3; ++r)
                out[(kAxes + k * 3 + r) * kGroupSplats + lane] = rotation[int(k)][int(r)] * splats.scaleM[i][int(k)];
        }
        out[kOpacity * kGroupSplats + lane] = splats.opacity[i];
        packSh(splats.sh.data() + size_t(i) * shFloats, shFloats, lane, out + kSh * kGroupSplats);
    }
}

}  // namespace dpl
