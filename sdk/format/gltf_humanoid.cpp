// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/gltf_humanoid.h"

#include <algorithm>
#include <utility>

namespace dpl {
namespace {

using Json = nlohmann::json;

/** The member of an object; null if there is none. */
const Json* at(const Json* object, const char* key) {
    if (!object || !object->is_object()) return nullptr;
    const auto found = object->find(key);
    return found == object->end() ? nullptr : &*found;
}

/** VRM 0 calls the first bone of the thumb proximal, VRM 1 metacarpal. */
std::string boneOfVrm0(const std::string& bone) {
    for (const std::string side : {"left", "right"}) {
        if (bone == side + "ThumbProximal") return side + "ThumbMetacarpal";
        if (bone == side + "ThumbIntermediate") return side + "ThumbProximal";
    }
    return bone;
}

Status mark(const std::string& bone, const Json* node, std::vector<GltfNode>& nodes) {
    if (!node || !node->is_number_integer() || (!node->is_number_unsigned() && node->get<int64_t>() < 0)) return {};  // −1: not mapped
    const uint64_t index = node->get<uint64_t>();
    if (index >= nodes.size())
        return fail(Code::CorruptData, "the humanoid map names node {} as '{}'; there are {}", index, bone, nodes.size());
    std::string& own = nodes[index].humanoidBone;
    if (own == bone) return {};
    if (!own.empty())
        return fail(Code::CorruptData, "the humanoid map names node {} ('{}') for two bones, '{}' and '{}'", index, nodes[index].name, own,
                    bone);
    const auto other = std::find_if(nodes.begin(), nodes.end(), [&](const GltfNode& n) { return n.humanoidBone == bone; });
    if (other != nodes.end())
        return fail(Code::CorruptData, "the humanoid map names two nodes as '{}': '{}' and '{}'", bone, other->name, nodes[index].name);
    own = bone;
    return {};
}

}  // namespace

Status readHumanoidMap(const Json& extensions, std::vector<GltfNode>& nodes) {
    for (const char* extension : {"VRMC_vrm_animation", "VRMC_vrm"}) {
        const Json* bones = at(at(at(&extensions, extension), "humanoid"), "humanBones");
        if (!bones || !bones->is_object()) continue;
        for (const auto& [bone, entry] : bones->items()) DPL_RETURN_IF_ERROR(mark(bone, at(&entry, "node"), nodes));
        return {};
    }
    const Json* bones = at(at(at(&extensions, "VRM"), "humanoid"), "humanBones");
    if (!bones || !bones->is_array()) return {};
    for (const Json& entry : *bones) {
        const Json* bone = at(&entry, "bone");
        if (bone && bone->is_string()) DPL_RETURN_IF_ERROR(mark(boneOfVrm0(bone->get<std::string>()), at(&entry, "node"), nodes));
    }
    return {};
}

}  // namespace dpl
