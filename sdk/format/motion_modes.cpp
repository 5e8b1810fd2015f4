// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/motion_modes.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "sdk/format/correctives.h"
#include "sdk/format/plain_bytes.h"

namespace dpl {
namespace {

constexpr float kMaxMode = 1e6f;               // as for the numbers of pose correctives
constexpr float kMaxAngle = 3.2f;              // an angle between two rotations is at most π
constexpr float kMaxDistance = 4 * kMaxAngle;  // √kMaxMotionJoints of them
constexpr float kUnit = 1e-3f;

bool within(float x, float low, float high) {  // false for NaN
    return x >= low && x <= high;
}

bool saneNumbers(const MotionModeData& m) {
    bool good = within(m.movedFromRad, 0, kMaxDistance) && within(m.movedToRad, 0, kMaxDistance) && m.movedFromRad < m.movedToRad;
    for (const MotionGroupData& g : m.groups) good = good && within(g.reach, 0, kMaxMode);
    for (const Vec4f& q : m.still) good = good && std::abs(glm::dot(q, q) - 1) <= kUnit;
    for (const Vec2f& range : m.rangeRad) good = good && within(range.x, 0, kMaxAngle) && within(range.y, 0, kMaxAngle);
    for (const float hold : m.holdsS) good = good && within(hold, 0, kMaxMotionHoldS);
    for (const float lag : m.lagsS) good = good && within(lag, kMinMotionLagS, kMaxMotionLagS);
    for (const float mode : m.modes) good = good && within(mode, -kMaxMode, kMaxMode);
    return good;
}

void setColumns(PoseCorrectiveData& c, uint32_t columns) {
    const uint32_t had = c.columnCount(), kept = std::min(had, columns);
    std::vector<Vec4f> nodes(size_t(c.nodeCount) * columns, Vec4f(0));
    for (size_t n = 0; n < c.nodeCount; ++n) std::copy_n(c.nodes.begin() + long(n * had), kept, nodes.begin() + long(n * columns));
    c.nodes = std::move(nodes);
}

Status checkGroups(const MotionModeData& m) {
    uint64_t columns = 0;
    bool whole = !m.groups.empty() && m.groups.size() <= kMaxMotionGroups;
    for (const MotionGroupData& g : m.groups) whole = whole && g.columnCount > 0, columns += g.columnCount;
    if (whole && columns < kMaxCorrectiveModes) return {};
    return fail(Code::CorruptData,
                "motion modes in {} groups of {} columns; 1 to {} groups of a column or more are possible, and {} columns", m.groups.size(),
                columns, kMaxMotionGroups, kMaxCorrectiveModes - 1);
}

}  // namespace

Status checkMotionModes(const MotionModeData& m, size_t jointCount) {
    if (m.empty()) return {};
    if (m.joints.empty() || m.joints.size() > kMaxMotionJoints || m.holdsS.empty() || m.holdsS.size() > kMaxMotionHolds ||
        m.lagsS.size() > kMaxMotionLags)
        return fail(Code::CorruptData, "motion modes of {} joints, {} holds and {} lags; 1 to {}, 1 to {} and 0 to {} are possible",
                    m.joints.size(), m.holdsS.size(), m.lagsS.size(), kMaxMotionJoints, kMaxMotionHolds, kMaxMotionLags);
    DPL_RETURN_IF_ERROR(checkGroups(m));
    if (m.still.size() != m.joints.size() || m.rangeRad.size() != m.joints.size() ||
        m.modes.size() != size_t(m.columnCount()) * m.featureCount())
        return fail(Code::CorruptData, "the arrays of the motion modes do not fit {} joints, {} holds, {} lags and {} columns",
                    m.joints.size(), m.holdsS.size(), m.lagsS.size(), m.columnCount());
    for (size_t i = 0; i < m.joints.size(); ++i)
        if (m.joints[i] >= jointCount || (i > 0 && m.joints[i] <= m.joints[i - 1]))
            return fail(Code::CorruptData, "motion modes name joint {} of {}; each joint is listed once, in rising order", m.joints[i],
                        jointCount);
    if (!saneNumbers(m)) return fail(Code::CorruptData, "motion modes hold an impossible angle, hold, lag, reach or mode");
    return {};
}

MotionStreams<std::vector<uint8_t>> encodeMotionModes(const MotionModeData& m) {
    return {bytesOf(m.groups), bytesOf(m.still), bytesOf(m.rangeRad), bytesOf(m.modes)};
}

Result<MotionModeData> decodeMotionModes(const MotionStreams<std::span<const uint8_t>>& in, MotionModeData m) {
    static_assert(sizeof(MotionGroupData) == 8);
    const size_t joints = m.joints.size();
    if (in.groups.size() % sizeof(MotionGroupData) != 0 || in.groups.size() > kMaxMotionGroups * sizeof(MotionGroupData))
        return fail(Code::CorruptData, "{} bytes of groups of motion modes; a group takes {}, and at most {} are possible",
                    in.groups.size(), sizeof(MotionGroupData), kMaxMotionGroups);
    fill(m.groups, in.groups);
    DPL_RETURN_IF_ERROR(checkGroups(m));
    if (in.still.size() != joints * sizeof(Vec4f) || in.ranges.size() != joints * sizeof(Vec2f) ||
        in.modes.size() != size_t(m.columnCount()) * m.featureCount() * sizeof(float))
        return fail(Code::CorruptData, "the streams of the motion modes do not hold {} joints, {} holds, {} lags and {} columns", joints,
                    m.holdsS.size(), m.lagsS.size(), m.columnCount());
    fill(m.still, in.still), fill(m.rangeRad, in.ranges), fill(m.modes, in.modes);
    return m;
}

uint64_t hashOfMotionModes(const MotionModeData& motion) {
    uint64_t hash = 0;
    const auto add = [&](const auto& values) { hash = XXH3_64bits_withSeed(values.data(), values.size() * sizeof values[0], hash); };
    add(motion.joints), add(motion.holdsS), add(motion.lagsS), add(motion.groups), add(motion.still), add(motion.rangeRad),
        add(motion.modes);
    add(std::array{motion.movedFromRad, motion.movedToRad});
    return hash;
}

void addMotionModes(PoseCorrectiveData& c, MotionModeData motion) {
    setColumns(c, c.modeCount + motion.columnCount());
    c.motion = std::move(motion);
}

void dropMotionModes(PoseCorrectiveData& c) {
    setColumns(c, c.modeCount);
    c.motion = {};
}

}  // namespace dpl
