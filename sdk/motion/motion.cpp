// SPDX-License-Identifier: Apache-2.0
#include "sdk/motion/motion.h"

#include <algorithm>
#include <array>
#include <cmath>

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

namespace {

/** What programs call a file that begins like this, and what to do with it. Empty: nothing known. */
std::string otherKind(std::string_view text) {
    const auto begins = [&](std::string_view with) { return text.starts_with(with); };
    constexpr std::string_view kBlender = "open it in Blender and export it as .glb or .bvh";
    if (text.empty()) return "an empty file";
    if (begins("Kaydara FBX Binary")) return formatText("an FBX file; {}", kBlender);
    const size_t zero = text.substr(0, 64).find('\0');
    if (begins("\xFF\xFE") || begins("\xFE\xFF") || zero == 1 || (zero == 0 && text.size() > 1 && text[1] != '\0'))
        return "text in UTF-16; save it as UTF-8 or plain ASCII";
    if (text.substr(std::min<size_t>(4, text.size()), 4) == "ftyp" || begins("\x1A\x45\xDF\xA3") || begins("RIFF"))
        return "a video; a motion has a skeleton, which a pose estimator or a motion capture program makes from videos";
    if (begins("\x89PNG") || begins("\xFF\xD8\xFF")) return "a picture";
    if (begins("PK\x03\x04") || begins("\x1F\x8B") || begins("7z\xBC\xAF") ||
        begins("\xFD"
               "7zXZ") ||
        begins("Rar!"))
        return "packed; unpack it and name the motion inside";
    if (begins("PXR-USDC") || begins("#usda")) return formatText("a USD file; {}", kBlender);
    if (begins("ply") || begins("NGSP")) return "general splats, which have no motion";
    if (begins("<?xml") || begins("<COLLADA")) return formatText("an XML file, perhaps COLLADA; {}", kBlender);
    const size_t word = std::min(text.find_first_not_of(" \t\r\n"), text.size());
    const std::string_view first = text.substr(word);
    if (first.starts_with("; FBX")) return formatText("an FBX file in ASCII; {}", kBlender);
    if (first.starts_with(":") || first.starts_with("#!OML"))
        return formatText("an Acclaim file (.asf or .amc) by its first line; {}", kBlender);
    if (first.starts_with("{") && first.substr(0, size_t(1) << 20).find("\"asset\"") != std::string_view::npos)
        return "a .gltf with its numbers in other files or as text; export it as one binary file (.glb)";
    if (first.starts_with("{") || first.starts_with("[")) return "JSON, but no motion of a kind that is read";
    return {};
}

}  // namespace

Result<Motion> readMotion(std::span<const uint8_t> bytes, std::string_view name, const MotionChoice& choice) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (text.starts_with("glTF")) return readGltfMotion(bytes, name, choice);
    if (const std::string kind = otherKind(text); !kind.empty())
        return fail(Code::Unsupported, "{}: motions are BVH texts and glTF binaries (.glb); this is {}", name, kind);
    if (!choice.animation.empty())
        return fail(Code::NotFound, "{}: there is no animation '{}': a BVH holds one motion; leave the choice out", name, choice.animation);
    return readBvh(text, name);
}

}  // namespace dpl
