// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/garments/body_parts.h"

#include <algorithm>
#include <array>

#include "sdk/avatar/humanoid.h"

namespace dpl {

std::vector<uint8_t> partsOfJoints(std::span<const JointData> joints, const std::map<std::string_view, uint8_t>& partOfBone) {
    const std::vector<std::string> bones = humanoidBones(joints);
    std::vector<uint8_t> parts(joints.size(), 0);
    for (size_t j = 0; j < joints.size(); ++j) {  // parents come first
        if (joints[j].parent >= 0) parts[j] = parts[size_t(joints[j].parent)];
        if (const auto named = partOfBone.find(bones[j]); named != partOfBone.end()) parts[j] = named->second;
    }
    return parts;
}

std::vector<uint8_t> partsOfTriangles(const MeshData& mesh, std::span<const uint8_t> ofJoint) {
    std::vector<uint8_t> parts;
    for (const Triangle& t : mesh.triangles) {
        std::array<int, 8> weight{};
        for (int c = 0; c < 3; ++c)
            for (int k = 0; k < 4; ++k)
                if (mesh.jointWeights[t[c]][k] != 0) weight[ofJoint[mesh.jointIndices[t[c]][k]]] += mesh.jointWeights[t[c]][k];
        parts.push_back(uint8_t(std::max_element(weight.begin(), weight.end()) - weight.begin()));
    }
    return parts;
}

}  // namespace dpl
