// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/splat_remarks.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sdk/math/sh.h"

namespace dpl {
namespace {

constexpr float kCoarseShare = 0.125f;  // of a splat's standard deviation: rounding of its place that a picture shows

}  // namespace

Status dropBroken(StaticSplatData& s, std::span<const uint32_t> broken, SplatRemarks& remarks) {
    if (broken.empty()) return {};
    const size_t n = s.position.size(), shFloats = shCoefficientCount(s.shDegree) * 3;
    if (broken.size() == n)
        return fail(Code::CorruptData, "none of its {} splats is finite; the training failed or the file is damaged", n);
    size_t kept = 0, next = 0;
    for (size_t i = 0; i < n; ++i) {
        if (next < broken.size() && broken[next] == i) {
            ++next;
            continue;
        }
        s.position[kept] = s.position[i], s.rotation[kept] = s.rotation[i], s.scaleM[kept] = s.scaleM[i], s.opacity[kept] = s.opacity[i];
        std::copy_n(s.sh.begin() + ptrdiff_t(i * shFloats), shFloats, s.sh.begin() + ptrdiff_t(kept * shFloats));
        ++kept;
    }
    s.position.resize(kept), s.rotation.resize(kept), s.scaleM.resize(kept), s.opacity.resize(kept), s.sh.resize(kept * shFloats);
    remarks.dropped += broken.size();
    remarks.notes.push_back(formatText("{} of {} splats left out: they have a number that is not finite (the first is splat {})",
                                       broken.size(), n, broken.front()));
    return {};
}

void noteShDegree(SplatRemarks& remarks) {
    if (remarks.shDegree > kMaxShDegree)
        remarks.notes.push_back(formatText("SH degree {}, drawn up to degree {}", remarks.shDegree, kMaxShDegree));
}

Status checkPrecision(const StaticSplatData& s, SplatRemarks& remarks) {
    if (s.position.empty()) return {};
    std::vector<float> shares;  // distance of neighbouring floats at the centre, as a share of the splat's size
    for (size_t i = 0; i < s.position.size(); ++i) {
        const Vec3f at = glm::abs(s.position[i]);
        const float largest = std::max({at.x, at.y, at.z}), size = std::max({s.scaleM[i].x, s.scaleM[i].y, s.scaleM[i].z});
        const float step = std::nextafter(largest, std::numeric_limits<float>::max()) - largest;
        shares.push_back(size > 0 ? step / size : 0);
    }
    const auto middle = shares.begin() + ptrdiff_t(shares.size() / 2);
    std::nth_element(shares.begin(), middle, shares.end());
    if (*middle < kCoarseShare) return {};
    const Vec3f& at = s.position.front();
    const auto whole = [](float m) { return std::abs(m) < 1e15f ? formatText("{}", int64_t(m)) : formatText("{}", m); };
    const std::string found = formatText("coordinates like ({}, {}, {}) are rounded to {} of a splat's size by 32-bit floats", whole(at.x),
                                         whole(at.y), whole(at.z), *middle);
    if (*middle > 1)
        return fail(
            Code::CorruptData,
            "{}, so their places are lost: subtract a local origin in double precision before the file is written (map coordinates?)",
            found);
    remarks.notes.push_back(found + "; subtract a local origin before the file is written");
    return {};
}

}  // namespace dpl
