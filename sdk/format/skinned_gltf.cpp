// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/skinned_gltf.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <glm/gtc/matrix_transform.hpp>

#include "sdk/format/gltf_model.h"

namespace dpl {
namespace {

using Mesh = SkinnedGltf::Mesh;

constexpr float kMostKeyValue = 1e9f;  // keeps squares and products finite

/** values: of one key, `count` of them: for cubic channels tangent, value, tangent. */
bool isSound(const Vec4f* values, size_t count, SkinnedGltf::Path path) {
    for (size_t i = 0; i < count; ++i)
        for (int c = 0; c < 4; ++c)
            if (!(std::abs(values[i][c]) <= kMostKeyValue)) return false;
    return path != SkinnedGltf::Path::Rotation || glm::length(values[count / 2]) > 1e-6f;
}

/** The longest row of sound keys whose times are finite and rise strictly. So one time that is far too large costs one key. */
std::vector<size_t> risingKeys(std::span<const float> times, const std::vector<bool>& sound) {
    std::vector<size_t> lastOf;  // lastOf[n]: the key of the least time that a row of n + 1 keys may end with
    std::vector<size_t> before(times.size(), SIZE_MAX);
    for (size_t k = 0; k < times.size(); ++k) {
        if (!sound[k] || !(std::abs(times[k]) <= kMostKeyValue)) continue;
        const auto at = std::lower_bound(lastOf.begin(), lastOf.end(), times[k], [&](size_t key, float time) { return times[key] < time; });
        if (at != lastOf.begin()) before[k] = *(at - 1);
        if (at == lastOf.end())
            lastOf.push_back(k);
        else if (times[k] < times[*at])
            *at = k;  // of equal times the first stays
    }
    std::vector<size_t> row;
    for (size_t k = lastOf.empty() ? SIZE_MAX : lastOf.back(); k != SIZE_MAX; k = before[k]) row.push_back(k);
    std::reverse(row.begin(), row.end());
    return row;
}

/** channels: what each lost. Empty if none lost anything. */
std::string sentenceOf(const std::vector<std::string>& channels) {
    constexpr size_t kMostNamed = 8;
    if (channels.empty()) return {};
    std::string text =
        "keys with a number that is not finite or above 1e9, a time that does not rise or a rotation of length 0 are left out: ";
    for (size_t i = 0; i < std::min(channels.size(), kMostNamed); ++i) text += (i > 0 ? ", " : "") + channels[i];
    return channels.size() > kMostNamed ? formatText("{} and of {} more channels", text, channels.size() - kMostNamed) : text;
}

struct SkinnedReader {
    const SkinnedGltfOptions& options;
    GltfModel model{};
    SkinnedGltf out{};
    std::vector<int32_t> nodeOf{};                 // node in the file -> index in out.nodes
    std::vector<std::vector<uint32_t>> jointOf{};  // per skin: joint of the skin -> index in out.joints
    uint64_t budget = 0;                           // bytes that may still be decoded, so that shared accessors cannot multiply memory

    Status spend(uint64_t bytes) {
        if (bytes > budget) return fail(Code::CorruptData, "the glTF decodes to far more than its own size; it is damaged or hostile");
        budget -= bytes;
        return {};
    }

    Result<std::vector<float>> floats(uint32_t accessor, uint32_t components) {
        DPL_RETURN_IF_ERROR(spend(uint64_t(model.accessors[accessor].count) * components * 4));
        return readFloats(model, accessor, components);
    }

    void readNodes() {
        nodeOf.assign(model.nodes.size(), -1);
        std::vector<uint32_t> stack;
        for (uint32_t root = uint32_t(model.nodes.size()); root-- > 0;)
            if (model.nodes[root].parent < 0) stack.push_back(root);
        while (!stack.empty()) {
            const uint32_t n = stack.back();
            stack.pop_back();
            const GltfNode& from = model.nodes[n];
            nodeOf[n] = int32_t(out.nodes.size());
            out.nodes.push_back(
                {from.name, from.parent < 0 ? -1 : nodeOf[from.parent], from.translation, from.rotation, from.scale, from.humanoidBone});
            for (size_t c = from.children.size(); c-- > 0;) stack.push_back(from.children[c]);
        }
    }

    Status readSkin(uint32_t index) {
        if (!jointOf[index].empty()) return {};
        const GltfSkin& skin = model.skins[index];
        std::vector<float> binds;
        if (skin.inverseBind >= 0) {
            DPL_TRY(binds, floats(uint32_t(skin.inverseBind), 16));
        }
        for (size_t j = 0; j < skin.joints.size(); ++j) {
            SkinnedGltf::Joint joint{uint32_t(nodeOf[skin.joints[j]]), Mat4f(1)};
            if (!binds.empty())
                for (int c = 0; c < 4; ++c)
                    joint.jointFromMesh[c] = Vec4f(binds[j * 16 + size_t(c) * 4], binds[j * 16 + size_t(c) * 4 + 1],
                                                   binds[j * 16 + size_t(c) * 4 + 2], binds[j * 16 + size_t(c) * 4 + 3]);
            auto same = std::find_if(out.joints.begin(), out.joints.end(), [&](const SkinnedGltf::Joint& other) {
                return other.node == joint.node && nearlyEqual(other.jointFromMesh, joint.jointFromMesh);
            });
            jointOf[index].push_back(uint32_t(same - out.joints.begin()));
            if (same == out.joints.end()) out.joints.push_back(joint);
            if (out.joints.size() > options.limits.maxJoints)
                return fail(Code::CorruptData, "more than {} joints", options.limits.maxJoints);
        }
        return {};
    }

    static bool nearlyEqual(const Mat4f& a, const Mat4f& b) {
        for (int c = 0; c < 4; ++c)
            for (int r = 0; r < 4; ++r)
                if (std::abs(a[c][r] - b[c][r]) > 1e-5f) return false;
        return true;
    }

    Status readMeshes() {
        for (uint32_t n = 0; n < model.nodes.size(); ++n) {
            const GltfNode& node = model.nodes[n];
            if (node.mesh < 0) continue;
            const GltfMesh& mesh = model.meshes[node.mesh];
            for (const GltfPrimitive& primitive : mesh.primitives) {
                if (primitive.mode != 4) continue;  // not triangles, so no part of a body
                DPL_RETURN_IF_ERROR(readMesh(mesh, primitive, node, n));
            }
        }
        return {};
    }

    Status readMesh(const GltfMesh& source, const GltfPrimitive& primitive, const GltfNode& node, uint32_t nodeIndex) {
        const uint64_t promised =
            primitive.attributes.contains("POSITION") ? model.accessors[primitive.attributes.at("POSITION")].count : 0;
        const uint64_t indices = primitive.indices >= 0 ? model.accessors[primitive.indices].count : promised;
        DPL_RETURN_IF_ERROR(spend(promised * 80 + indices * 4));
        DPL_TRY(PrimitiveReader reader, PrimitiveReader::open(model, primitive, options.limits));
        Mesh& to = out.meshes.emplace_back();
        to.name = source.name.empty() ? node.name : source.name;
        to.node = nodeOf[nodeIndex];
        to.triangles = std::move(reader.triangles());
        const uint32_t n = reader.vertexCount();
        DPL_TRY(const std::vector<float> positions, reader.floats("POSITION", 3));
        for (uint32_t v = 0; v < n; ++v) to.positions.emplace_back(positions[v * 3], positions[v * 3 + 1], positions[v * 3 + 2]);
        if (reader.has("TEXCOORD_0")) {
            DPL_TRY(const std::vector<float> uv, reader.floats("TEXCOORD_0", 2));
            for (uint32_t v = 0; v < n; ++v) to.uv.emplace_back(uv[v * 2], uv[v * 2 + 1]);
        }
        if (reader.has("COLOR_0")) {
            const uint32_t components = reader.componentsOf("COLOR_0");
            DPL_TRY(const std::vector<float> c, reader.floats("COLOR_0", components == 4 ? 4 : 3));
            for (uint32_t v = 0; v < n; ++v)
                to.colours.push_back(components == 4 ? Vec4f(c[v * 4], c[v * 4 + 1], c[v * 4 + 2], c[v * 4 + 3])
                                                     : Vec4f(c[v * 3], c[v * 3 + 1], c[v * 3 + 2], 1));
        }
        if (node.skin >= 0 && reader.has("JOINTS_0") && reader.has("WEIGHTS_0")) {
            DPL_RETURN_IF_ERROR(readSkin(uint32_t(node.skin)));
            DPL_RETURN_IF_ERROR(readWeights(reader, uint32_t(node.skin), to));
        }
        return readMorphs(source, primitive, n, to);
    }

    /** Reads up to eight influences per vertex and keeps the four largest. */
    Status readWeights(const PrimitiveReader& reader, uint32_t skin, Mesh& to) {
        const uint32_t n = reader.vertexCount(), sets = reader.has("JOINTS_1") && reader.has("WEIGHTS_1") ? 2 : 1;
        std::vector<float> joints[2], weights[2];
        for (uint32_t set = 0; set < sets; ++set) {
            DPL_TRY(joints[set], reader.floats(set ? "JOINTS_1" : "JOINTS_0", 4));
            DPL_TRY(weights[set], reader.floats(set ? "WEIGHTS_1" : "WEIGHTS_0", 4));
        }
        to.skinned = true;
        to.jointIndices.assign(n, glm::u16vec4(0)), to.jointWeights.assign(n, Vec4f(0));
        for (uint32_t v = 0; v < n; ++v) {
            std::pair<float, uint32_t> influences[8] = {};
            for (uint32_t k = 0; k < sets * 4; ++k) {
                const float joint = joints[k / 4][v * 4 + k % 4], weight = weights[k / 4][v * 4 + k % 4];
                if (!(weight > 0)) continue;
                if (joint < 0 || joint >= float(jointOf[skin].size()))
                    return fail(Code::CorruptData, "vertex {} of mesh '{}' follows joint {} of {}", v, to.name, joint,
                                jointOf[skin].size());
                influences[k] = {weight, jointOf[skin][size_t(joint)]};
            }
            std::stable_sort(influences, influences + 8, [](const auto& a, const auto& b) { return a.first > b.first; });
            const float sum = influences[0].first + influences[1].first + influences[2].first + influences[3].first;
            if (!(sum > 0))
                return fail(Code::CorruptData, "vertex {} of mesh '{}' follows no joint: all its skin weights are 0", v, to.name);
            for (int k = 0; k < 4; ++k)
                to.jointWeights[v][k] = influences[k].first / sum, to.jointIndices[v][k] = uint16_t(influences[k].second);
        }
        return {};
    }

    Status readMorphs(const GltfMesh& source, const GltfPrimitive& primitive, uint32_t vertexCount, Mesh& to) {
        for (size_t t = 0; t < primitive.targets.size(); ++t) {
            SkinnedGltf::Morph& morph = to.morphs.emplace_back();
            morph.name =
                t < source.targetNames.size() && !source.targetNames[t].empty() ? source.targetNames[t] : "morph" + std::to_string(t);
            morph.restWeight = t < source.weights.size() ? source.weights[t] : 0;
            DPL_RETURN_IF_ERROR(spend(uint64_t(vertexCount) * 12));
            morph.offsets.assign(vertexCount, Vec3f(0));
            const auto position = primitive.targets[t].find("POSITION");
            if (position == primitive.targets[t].end()) continue;
            const GltfAccessor& accessor = model.accessors[position->second];
            if (accessor.count != vertexCount)
                return fail(Code::CorruptData, "morph '{}' has {} offsets for {} vertices", morph.name, accessor.count, vertexCount);
            if (accessor.view < 0 && accessor.sparse.count == 0) continue;  // glTF: an accessor without data is all zeros
            DPL_TRY(const std::vector<float> offsets, floats(position->second, 3));
            for (uint32_t v = 0; v < vertexCount; ++v) morph.offsets[v] = Vec3f(offsets[v * 3], offsets[v * 3 + 1], offsets[v * 3 + 2]);
        }
        return {};
    }

    /** Without keys if none is sound. Adds what it leaves out to `leftOut`. */
    Result<SkinnedGltf::Channel> readChannel(const GltfAnimation& from, const GltfAnimation::Channel& source,
                                             std::vector<std::string>& leftOut) {
        const GltfAnimation::Sampler& sampler = from.samplers[source.sampler];
        SkinnedGltf::Channel channel;
        channel.node = uint32_t(nodeOf[source.node]);
        channel.path = source.path == "rotation"      ? SkinnedGltf::Path::Rotation
                       : source.path == "translation" ? SkinnedGltf::Path::Translation
                                                      : SkinnedGltf::Path::Scale;
        channel.interpolation = sampler.interpolation == "STEP"          ? SkinnedGltf::Interpolation::Step
                                : sampler.interpolation == "CUBICSPLINE" ? SkinnedGltf::Interpolation::Cubic
                                                                         : SkinnedGltf::Interpolation::Linear;
        const uint32_t components = channel.path == SkinnedGltf::Path::Rotation ? 4 : 3;
        DPL_RETURN_IF_ERROR(spend(uint64_t(model.accessors[sampler.input].count) * 4));
        DPL_RETURN_IF_ERROR(spend(uint64_t(model.accessors[sampler.output].count) * components * 4));
        DPL_TRY(const std::vector<float> times, readAnyFloats(model, sampler.input, 1));
        DPL_TRY(const std::vector<float> values, readAnyFloats(model, sampler.output, components));
        const size_t perKey = channel.interpolation == SkinnedGltf::Interpolation::Cubic ? 3 : 1;
        if (times.empty() || values.size() != times.size() * perKey * components)
            return fail(Code::CorruptData, "animation '{}' has {} times and {} values", from.name, times.size(),
                        values.size() / components);
        std::vector<Vec4f> all;
        for (size_t i = 0; i < values.size(); i += components)
            all.emplace_back(values[i], values[i + 1], values[i + 2], components == 4 ? values[i + 3] : 0.0f);
        std::vector<bool> sound(times.size());
        for (size_t k = 0; k < times.size(); ++k) sound[k] = isSound(&all[k * perKey], perKey, channel.path);
        for (const size_t k : risingKeys(times, sound)) {
            channel.timesS.push_back(times[k]);
            channel.values.insert(channel.values.end(), &all[k * perKey], &all[k * perKey] + perKey);
        }
        if (const size_t lost = times.size() - channel.timesS.size(); lost > 0)
            leftOut.push_back(formatText("{} of {} in the {} of '{}'", lost, times.size(), source.path, out.nodes[channel.node].name));
        return channel;
    }

    Status readAnimations() {
        for (const GltfAnimation& from : model.animations) {
            SkinnedGltf::Animation& to = out.animations.emplace_back();
            to.name = from.name;
            std::vector<std::string> leftOut;
            for (const GltfAnimation::Channel& source : from.channels) {
                if (source.node < 0 || (source.path != "rotation" && source.path != "translation" && source.path != "scale")) continue;
                DPL_TRY(SkinnedGltf::Channel channel, readChannel(from, source, leftOut));
                if (!channel.timesS.empty()) to.channels.push_back(std::move(channel));
            }
            to.leftOut = sentenceOf(leftOut);
        }
        return {};
    }

    Status read(std::span<const uint8_t> bytes) {
        DPL_TRY(model, parseGlb(bytes, options.limits));
        budget = (256ull << 20) + uint64_t(bytes.size()) * 16;
        jointOf.resize(model.skins.size());
        readNodes();
        DPL_RETURN_IF_ERROR(readMeshes());
        DPL_RETURN_IF_ERROR(readAnimations());
        if (!options.requireSkin) return {};
        if (out.meshes.empty()) return fail(Code::NotFound, "the glTF has no triangle mesh");
        if (std::none_of(out.meshes.begin(), out.meshes.end(), [](const Mesh& m) { return m.skinned; }))
            return fail(Code::NotFound,
                        "the glTF has no skin weights: a body needs a skeleton with JOINTS_0 and WEIGHTS_0 on its mesh; rig it and export "
                        "with skinning");
        return {};
    }
};

Quatf quaternion(const Vec4f& v) {
    return {v.w, v.x, v.y, v.z};
}
Vec4f unit(const Quatf& q) {
    const float length = glm::length(q);
    const Quatf r = length > 1e-8f ? q / length : Quatf(1, 0, 0, 0);
    return {r.x, r.y, r.z, r.w};
}

}  // namespace

Result<SkinnedGltf> readSkinnedGltf(std::span<const uint8_t> bytes, const SkinnedGltfOptions& options) try {
    SkinnedReader reader{options};
    DPL_RETURN_IF_ERROR(reader.read(bytes));
    return std::move(reader.out);
} catch (const std::bad_alloc&) {
    return outOfMemory("read a glTF");
} catch (const std::exception& e) {
    return fail(Code::CorruptData, "the glTF cannot be read: {}", e.what());
}

std::vector<Mat4f> SkinnedGltf::restTransforms() const {
    std::vector<Mat4f> scene(nodes.size());
    for (size_t n = 0; n < nodes.size(); ++n) {
        const Node& node = nodes[n];
        const Mat4f local = glm::translate(Mat4f(1), node.translation) * glm::mat4_cast(node.rotation) * glm::scale(Mat4f(1), node.scale);
        scene[n] = node.parent < 0 ? local : scene[size_t(node.parent)] * local;
    }
    return scene;
}

float SkinnedGltf::Animation::endS() const {
    float end = 0;
    for (const Channel& channel : channels) end = std::max(end, channel.timesS.empty() ? 0.0f : channel.timesS.back());
    return end;
}

Vec4f sampleChannel(const SkinnedGltf::Channel& c, float timeS) {
    const bool rotation = c.path == SkinnedGltf::Path::Rotation, cubic = c.interpolation == SkinnedGltf::Interpolation::Cubic;
    auto key = [&](size_t i) { return cubic ? c.values[i * 3 + 1] : c.values[i]; };
    auto finish = [&](const Vec4f& v) { return rotation ? unit(quaternion(v)) : v; };
    const size_t next = size_t(std::upper_bound(c.timesS.begin(), c.timesS.end(), timeS) - c.timesS.begin());
    if (next == 0) return finish(key(0));
    if (next == c.timesS.size() || c.interpolation == SkinnedGltf::Interpolation::Step) return finish(key(next - 1));
    const size_t i = next - 1;
    const float span = c.timesS[next] - c.timesS[i], t = (timeS - c.timesS[i]) / span;
    if (cubic) {
        const float t2 = t * t, t3 = t2 * t;
        return finish((2 * t3 - 3 * t2 + 1) * key(i) + span * (t3 - 2 * t2 + t) * c.values[i * 3 + 2] + (3 * t2 - 2 * t3) * key(next) +
                      span * (t3 - t2) * c.values[next * 3]);
    }
    if (!rotation) return key(i) + t * (key(next) - key(i));
    return unit(glm::slerp(glm::normalize(quaternion(key(i))), glm::normalize(quaternion(key(next))), t));
}

}  // namespace dpl
