// SPDX-License-Identifier: Apache-2.0
#include "sdk/motion/motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace dpl {

void motionAt(const Motion& motion, size_t key, std::vector<Quatf>& rotations, std::vector<Vec3f>& positions) {
    const size_t jointCount = motion.joints.size();
    rotations.resize(jointCount);
    positions.assign(jointCount, Vec3f(0));
    for (const Motion::Translation& translation : motion.translations) positions[translation.joint] = translation.offsets[key];
    const Quatf* local = motion.rotations.data() + key * jointCount;
    for (size_t j = 0; j < jointCount; ++j) {
        const JointData& joint = motion.joints[j];
        if (joint.parent < 0) {
            rotations[j] = local[j];
            positions[j] += joint.restPosition;
            continue;
        }
        const size_t p = size_t(joint.parent);
        positions[j] = positions[p] + rotations[p] * (joint.restPosition - motion.joints[p].restPosition + positions[j]);
        rotations[j] = glm::normalize(rotations[p] * local[j]);
    }
}

float guessMetresPerUnit(float height) {
    constexpr std::array<float, 5> kUnits = {1.0f, 0.1f, 0.0254f, 0.01f, 0.001f};
    constexpr float kUsualHeightM = 1.7f;
    float best = 1;
    for (float unit : kUnits)
        if (std::abs(std::log(height * unit / kUsualHeightM)) < std::abs(std::log(height * best / kUsualHeightM))) best = unit;
    return best;
}

void scaleToMetres(Motion& motion) {
    Vec3f lowest(1e30f), highest(-1e30f);
    for (const JointData& joint : motion.joints) {
        lowest = glm::min(lowest, joint.restPosition);
        highest = glm::max(highest, joint.restPosition);
    }
    const Vec3f size = highest - lowest;
    // Up may be y or z. In a T-pose the arm span is about the height, so the largest extent serves.
    const float height = std::max(size.x, std::max(size.y, size.z));
    if (!(height > 0) || !std::isfinite(height)) return;
    const float unit = guessMetresPerUnit(height);
    motion.metresPerUnit = unit;
    for (JointData& joint : motion.joints) joint.restPosition *= unit;
    for (Motion::Translation& translation : motion.translations)
        for (Vec3f& offset : translation.offsets) offset *= unit;
}

Result<Motion> readMotion(std::span<const uint8_t> bytes, std::string_view name, uint32_t animation) {
    if (bytes.size() >= 4 && std::memcmp(bytes.data(), "glTF", 4) == 0) return readGltfMotion(bytes, name, animation);
    return readBvh({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, name);
}

}  // namespace dpl
