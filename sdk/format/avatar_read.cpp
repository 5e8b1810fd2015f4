// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "sdk/core/task.h"
#include "sdk/format/avatar_check.h"
#include "sdk/format/avatar_file.h"
#include "sdk/format/content_hash.h"
#include "sdk/format/correctives.h"
#include "sdk/format/correctives_compact.h"
#include "sdk/format/extension_fields.h"
#include "sdk/format/gltf_model.h"
#include "sdk/format/ignorable_parts.h"
#include "sdk/format/motion_modes.h"
#include "sdk/format/splat_codec.h"
#include "sdk/format/vertex_colour.h"

namespace dpl {
namespace {

using Json = nlohmann::json;
using Fields = ExtensionFields;

struct AvatarReader {
    const ReadLimits& limits;
    GltfModel model{};
    std::optional<JsonReserve> reserve{};  // before the values that need it
    Json extension{};
    AvatarInfo info{};
    AvatarData avatar{};  // without splats
    CodedSplats coded{};
    std::set<uint32_t> spentViews{};
    uint64_t budget = 0;  // bytes that may still be decoded; about one for each byte of the file, so shared views cannot multiply memory

    Status spend(uint64_t bytes) {
        if (bytes > budget)
            return fail(Code::CorruptData, "the file uses the same bytes many times; it claims to hold more than its own size");
        budget -= bytes;
        return {};
    }

    Status open(std::span<const uint8_t> bytes) {
        DPL_TRY(model, parseGlb(bytes, limits));
        if (model.avatarExtension.empty())
            return fail(
                Code::Unsupported,
                "a glTF without DPL_gaussian_avatar: not a Doppel avatar, or saved again by an editor that drops unknown extensions");
        reserve.emplace(model.jsonValues);
        extension = Json::parse(model.avatarExtension, nullptr, false);
        const Fields root(extension, "DPL_gaussian_avatar");
        DPL_TRY(const uint64_t version, root.number("version", 0xffffffffu));
        if (version > kAvatarFormatVersion)
            return fail(Code::Version, "avatar format {}; this build reads up to {}: update Doppel or export again", version,
                        kAvatarFormatVersion);
        if (version < 1) return fail(Code::CorruptData, "avatar format 0 does not exist");
        const size_t digits = findHashDigits(model.json);
        if (digits == std::string_view::npos) return fail(Code::CorruptData, "DPL_gaussian_avatar: 'contentHash' is missing or malformed");
        info.contentHash = "xxh3:" + std::string(model.json.substr(digits, kHashDigits));
        info.hashMatches = contentHash(model.json, digits, model.bin) == model.json.substr(digits, kHashDigits);
        if (limits.verifyHash && !info.hashMatches)
            return fail(Code::CorruptData, "the content hash does not match: the file is damaged or was edited");
        info.version = uint32_t(version), info.fileBytes = bytes.size(), info.jsonBytes = model.json.size();
        budget = model.bin.size();
        return {};
    }

    Status readHead() {
        const Fields root(extension, "DPL_gaussian_avatar");
        DPL_RETURN_IF_ERROR(root.mustBe("units", "metre"));
        DPL_RETURN_IF_ERROR(root.mustBe("handedness", "right"));
        DPL_RETURN_IF_ERROR(root.mustBe("up", "+Y"));
        DPL_RETURN_IF_ERROR(root.mustBe("front", "+Z"));
        DPL_RETURN_IF_ERROR(root.mustBe("colourSpace", "srgb-display"));
        DPL_TRY(avatar.name, root.text("name"));
        DPL_TRY(avatar.kappaPx2, root.real("kappaPx2"));
        DPL_TRY(avatar.compensated, root.flag("compensated"));
        if (root.has("trainedPixelM")) {
            DPL_TRY(avatar.trainedPixelM, root.real("trainedPixelM"));
            if (avatar.trainedPixelM == 0)
                return fail(Code::CorruptData, "DPL_gaussian_avatar: 'trainedPixelM' is 0; a file leaves it out if it is not known");
        }
        avatar.generator = model.generator;
        DPL_TRY(const Json* evidence, root.array("evidence"));
        for (const Json& row : *evidence) {
            const Fields fields(row, "evidence");
            EvidenceData e;
            DPL_TRY(e.part, fields.text("part"));
            DPL_TRY(e.kept, fields.flag("kept"));
            DPL_TRY(e.gainDb, fields.real("gainDb"));
            DPL_TRY(e.bytes, fields.number("bytes", ~0ull));
            DPL_TRY(e.reason, fields.text("reason"));
            avatar.evidence.push_back(std::move(e));
        }
        return {};
    }

    Status readJoints() {
        const Fields root(extension, "DPL_gaussian_avatar");
        DPL_TRY(const uint64_t skinIndex, root.number("skin", 0xffffffffu));
        if (skinIndex >= model.skins.size())
            return fail(Code::CorruptData, "the avatar names skin {}, there are {}", skinIndex, model.skins.size());
        const GltfSkin& skin = model.skins[skinIndex];
        if (skin.inverseBind < 0) return fail(Code::CorruptData, "the skin has no inverse bind matrices");
        DPL_RETURN_IF_ERROR(spend(uint64_t(model.accessors[skin.inverseBind].count) * 64));
        DPL_TRY(const std::vector<float> binds, readFloats(model, uint32_t(skin.inverseBind), 16));
        info.skinBytes = binds.size() * 4;
        std::vector<int32_t> jointOfNode(model.nodes.size(), -1);
        for (size_t j = 0; j < skin.joints.size(); ++j) {
            const GltfNode& node = model.nodes[skin.joints[j]];
            if (jointOfNode[skin.joints[j]] >= 0) return fail(Code::CorruptData, "node {} is listed as a joint twice", skin.joints[j]);
            jointOfNode[skin.joints[j]] = int32_t(j);
            JointData joint;
            joint.name = node.name;
            joint.parent = node.parent < 0 ? -1 : jointOfNode[node.parent];
            if (j > 0 && joint.parent < 0)
                return fail(Code::CorruptData, "joint {} ('{}') does not come after its parent joint", j, node.name);
            const float* m = &binds[j * 16];
            joint.restPosition = Vec3f(0.0f - m[12], 0.0f - m[13], 0.0f - m[14]);
            for (int k = 0; k < 12; ++k)
                if (m[k] != (k % 5 == 0 ? 1.0f : 0.0f))
                    return fail(Code::CorruptData, "the bind matrix of joint {} turns or scales; avatar joints are parallel to the world",
                                j);
            // Doppel writes positions on a lattice, so node and bind matrix agree exactly. The tolerance is for other writers.
            const Vec3f parent = joint.parent < 0 ? Vec3f(0) : avatar.joints[joint.parent].restPosition;
            const bool turned = std::abs(node.rotation.w) < 0.999999f || glm::length(node.scale - Vec3f(1)) > 1e-5f;
            if (turned || !(glm::length(node.translation + parent - joint.restPosition) < 1e-4f))
                return fail(Code::CorruptData, "joint {} ('{}') is not where its bind matrix places it", j, node.name);
            avatar.joints.push_back(std::move(joint));
        }
        DPL_TRY(const Json* bones, root.array("humanoidBones"));
        for (const Json& entry : *bones) {
            const Fields fields(entry, "humanoidBones");
            DPL_TRY(const uint64_t joint, fields.number("joint", 0xffffffffu));
            if (joint >= avatar.joints.size())
                return fail(Code::CorruptData, "a humanoid bone names joint {} of {}", joint, avatar.joints.size());
            std::string& bone = avatar.joints[joint].humanoidBone;
            DPL_TRY(std::string named, fields.text("bone"));
            if (!bone.empty())
                return fail(Code::CorruptData, "joint {} ('{}') is named as two humanoid bones, '{}' and '{}'", joint,
                            avatar.joints[joint].name, bone, named);
            bone = std::move(named);
        }
        return readClips(jointOfNode);
    }

    Status readClips(const std::vector<int32_t>& jointOfNode) {
        for (const GltfAnimation& animation : model.animations) {
            ClipData clip;
            clip.name = animation.name;
            int64_t input = -1;
            for (const GltfAnimation::Channel& channel : animation.channels) {
                const auto& sampler = animation.samplers[channel.sampler];
                if (channel.node < 0 || jointOfNode[channel.node] < 0)
                    return fail(Code::CorruptData, "clip '{}' moves a node that is no joint", clip.name);
                if (input >= 0 && sampler.input != input)
                    return fail(Code::Unsupported, "clip '{}' has channels with different times; resample it", clip.name);
                if (sampler.interpolation != "LINEAR") return fail(Code::Unsupported, "clip '{}' is not linear; resample it", clip.name);
                if (input < 0) {
                    input = sampler.input;
                    DPL_RETURN_IF_ERROR(spend(uint64_t(model.accessors[sampler.input].count) * 4));
                    DPL_TRY(clip.timesS, readFloats(model, sampler.input, 1));
                    info.clipBytes += clip.timesS.size() * 4;
                }
                const uint32_t joint = uint32_t(jointOfNode[channel.node]), components = channel.path == "rotation" ? 4 : 3;
                DPL_RETURN_IF_ERROR(spend(uint64_t(model.accessors[sampler.output].count) * components * 4));
                DPL_TRY(const std::vector<float> values, readFloats(model, sampler.output, components));
                info.clipBytes += values.size() * 4;
                if (channel.path == "rotation") {
                    ClipChannel& to = clip.channels.emplace_back();
                    to.joint = joint;
                    for (size_t i = 0; i + 3 < values.size(); i += 4)
                        to.rotations.emplace_back(values[i + 3], values[i], values[i + 1], values[i + 2]);
                } else if (channel.path == "translation" && joint == 0) {
                    for (size_t i = 0; i + 2 < values.size(); i += 3)
                        clip.rootTranslations.push_back(Vec3f(values[i], values[i + 1], values[i + 2]) - avatar.joints[0].restPosition);
                } else {
                    return fail(Code::Unsupported, "clip '{}' has a {} channel; joints only turn, and the root may move", clip.name,
                                channel.path);
                }
            }
            avatar.clips.push_back(std::move(clip));
        }
        return {};
    }

    Status readLayers() {
        const Fields root(extension, "DPL_gaussian_avatar");
        DPL_TRY(const Json* layers, root.array("layers"));
        MeshData& mesh = avatar.mesh;
        for (const Json& entry : *layers) {
            const Fields fields(entry, "layers");
            LayerData layer;
            DPL_TRY(layer.role, fields.text("role"));
            DPL_TRY(const uint64_t meshIndex, fields.number("mesh", 0xffffffffu));
            if (meshIndex >= model.meshes.size() || model.meshes[meshIndex].primitives.size() != 1)
                return fail(Code::CorruptData, "layer {} names mesh {}, which is missing or has several parts", mesh.layers.size(),
                            meshIndex);
            layer.name = model.meshes[meshIndex].name;
            DPL_RETURN_IF_ERROR(readLayer(model.meshes[meshIndex].primitives[0], layer));
            mesh.layers.push_back(std::move(layer));
        }
        return {};
    }

    Status readLayer(const GltfPrimitive& primitive, LayerData& layer) {
        MeshData& mesh = avatar.mesh;
        ReadLimits left = limits;
        left.maxVertices -= uint32_t(mesh.restPositions.size()), left.maxTriangles -= uint32_t(mesh.triangles.size());
        const uint64_t vertices =
            primitive.attributes.contains("POSITION") ? model.accessors[primitive.attributes.at("POSITION")].count : 0;
        const uint64_t indices = primitive.indices >= 0 ? model.accessors[primitive.indices].count : 0;
        const uint64_t bytes = primitive.dracoView >= 0 ? model.views[primitive.dracoView].length : vertices * 28 + indices;
        DPL_RETURN_IF_ERROR(spend(bytes));
        DPL_TRY(PrimitiveReader reader, PrimitiveReader::open(model, primitive, left));
        DPL_TRY(const std::vector<float> positions, reader.floats("POSITION", 3));
        DPL_TRY(const std::vector<float> colours, reader.floats("COLOR_0", 4));
        DPL_TRY(const std::vector<float> joints, reader.floats("JOINTS_0", 4));
        DPL_TRY(const std::vector<float> weights, reader.floats("WEIGHTS_0", 4));
        info.meshBytes += primitive.dracoView >= 0 ? bytes : plainBytes(primitive);
        layer.firstVertex = uint32_t(mesh.restPositions.size()), layer.vertexCount = reader.vertexCount();
        layer.firstTriangle = uint32_t(mesh.triangles.size()), layer.triangleCount = uint32_t(reader.triangles().size());
        for (uint32_t v = 0; v < layer.vertexCount; ++v) {
            mesh.restPositions.emplace_back(positions[v * 3], positions[v * 3 + 1], positions[v * 3 + 2]);
            glm::u8vec4 colour, weight;
            glm::u16vec4 joint;
            for (int k = 0; k < 4; ++k) {
                colour[k] =
                    k < 3 ? srgb8FromLinear(colours[v * 4 + k]) : uint8_t(std::lround(std::clamp(colours[v * 4 + k], 0.0f, 1.0f) * 255));
                weight[k] = uint8_t(std::lround(std::clamp(weights[v * 4 + k], 0.0f, 1.0f) * 255));
                joint[k] = uint16_t(std::clamp(joints[v * 4 + k], 0.0f, 65535.0f));
            }
            mesh.colours.push_back(colour), mesh.jointWeights.push_back(weight), mesh.jointIndices.push_back(joint);
        }
        for (const glm::uvec3& t : reader.triangles()) mesh.triangles.push_back(t + layer.firstVertex);
        return {};
    }

    uint64_t plainBytes(const GltfPrimitive& primitive) {
        uint64_t bytes = 0;
        auto add = [&](uint32_t accessor) {
            const int32_t view = model.accessors[accessor].view;
            if (view >= 0 && spentViews.insert(uint32_t(view)).second) bytes += model.views[view].length;
        };
        for (const auto& [semantic, accessor] : primitive.attributes) add(accessor);
        if (primitive.indices >= 0) add(uint32_t(primitive.indices));
        return bytes;
    }

    Status readSplats() {
        const Fields root(extension, "DPL_gaussian_avatar");
        DPL_TRY(const Json* object, root.object("splats"));
        const Fields splats(*object, "splats");
        DPL_TRY(const uint64_t encoding, splats.number("encoding", 0xffffffffu));
        if (encoding < 1 || encoding > 3)
            return fail(Code::Version, "splat encoding {}; this build reads 1 to 3: update Doppel or export again", encoding);
        DPL_RETURN_IF_ERROR(splats.mustBe("shBasis", "3dgs-real"));
        DPL_TRY(const uint64_t chunkSize, splats.number("chunkSize", 0xffffffffu));
        if (chunkSize != kSplatChunkSize)
            return fail(Code::Unsupported, "chunks of {} splats; encodings 1 to 3 have {}", chunkSize, kSplatChunkSize);
        DPL_TRY(const uint64_t count, splats.number("count", limits.maxSplats));
        DPL_TRY(const uint64_t degree, splats.number("shDegree", 3));
        SplatHead head{uint32_t(count), uint32_t(degree), 0, {}};
        if (encoding == 3) {
            DPL_TRY(head.bits, readBits(splats));
        }
        if (encoding == 2 || (encoding == 3 && splats.has("shPaletteSize"))) {
            DPL_TRY(const uint64_t entries, splats.number("shPaletteSize", kMaxShPalette));
            if (entries == 0) return fail(Code::CorruptData, "splat encoding {} with an empty SH palette", encoding);
            head.paletteSize = uint32_t(entries);
        }
        DPL_TRY(const Json* streams, splats.object("streams"));
        SplatStreams<std::span<const uint8_t>> in;
        DPL_TRY(in.triangleCounts, stream(*streams, "triangleCounts"));
        DPL_TRY(in.chunks, stream(*streams, "chunks"));
        DPL_TRY(in.place, stream(*streams, "place"));
        DPL_TRY(in.size, stream(*streams, "size"));
        DPL_TRY(in.colour, stream(*streams, "colour"));
        DPL_TRY(in.shIndex, stream(*streams, "shIndex"));
        DPL_TRY(in.ranges, stream(*streams, "ranges"));
        DPL_TRY(in.coded, stream(*streams, "coded"));
        DPL_TRY(in.sh, stream(*streams, "sh"));
        DPL_TRY(coded, readSplatStreams(in, avatar.mesh, head, limits));
        info.splatBytes = in.triangleCounts.size() + in.chunks.size() + in.place.size() + in.size.size() + in.colour.size() +
                          in.ranges.size() + in.coded.size();
        info.shBytes = in.sh.size() + in.shIndex.size();
        info.shPaletteSize = head.paletteSize;
        info.splatEncoding = uint32_t(encoding), info.bits = head.bits.value_or(SplatBits());
        info.chunks = uint32_t(coded.chunks.size());
        info.splats = coded.count(), info.shDegree = coded.shDegree;
        return {};
    }

    Result<SplatBits> readBits(const Fields& splats) {
        DPL_TRY(const Json* object, splats.object("bits"));
        const Fields fields(*object, "bits");
        SplatBits bits;
        DPL_TRY(bits.uv, fields.number("uv", 255));
        DPL_TRY(bits.phi, fields.number("phi", 255));
        DPL_TRY(bits.scale, fields.number("scale", 255));
        DPL_TRY(bits.opacity, fields.number("opacity", 255));
        DPL_TRY(bits.colour, fields.number("colour", 255));
        return bits;
    }

    Result<MotionModeData> readMotionModes(const Fields& correctives) {
        MotionModeData head;
        if (!correctives.has("motion")) return head;
        if (info.version < 3) return fail(Code::CorruptData, "motion modes in a file of version {}, which has none", info.version);
        DPL_TRY(const Json* object, correctives.object("motion"));
        const Fields fields(*object, "motion");
        DPL_TRY(const uint64_t encoding, fields.number("encoding", 0xffffffffu));
        if (encoding != 1)
            return fail(Code::Version, "motion mode encoding {}; this build reads 1: update Doppel or export again", encoding);
        DPL_TRY(head.joints, fields.numbers("joints", kMaxMotionJoints, limits.maxJoints - 1));
        DPL_TRY(head.movedFromRad, fields.real("movedFrom"));
        DPL_TRY(head.movedToRad, fields.real("movedTo"));
        DPL_TRY(head.holdsS, fields.reals("holds", kMaxMotionHolds));
        if (fields.has("lags")) {
            DPL_TRY(head.lagsS, fields.reals("lags", kMaxMotionLags));
        }
        DPL_TRY(const Json* streams, fields.object("streams"));
        MotionStreams<std::span<const uint8_t>> in;
        DPL_TRY(in.groups, stream(*streams, "groups"));
        DPL_TRY(in.still, stream(*streams, "still"));
        DPL_TRY(in.ranges, stream(*streams, "ranges"));
        DPL_TRY(in.modes, stream(*streams, "modes"));
        info.correctiveBytes += in.groups.size() + in.still.size() + in.ranges.size() + in.modes.size();
        return decodeMotionModes(in, std::move(head));
    }

    Status readCorrectives() {
        const Fields root(extension, "DPL_gaussian_avatar");
        if (!root.has("poseCorrectives")) return {};
        if (info.version < 2) return fail(Code::CorruptData, "pose correctives in a file of version {}, which has none", info.version);
        DPL_TRY(const Json* object, root.object("poseCorrectives"));
        const Fields fields(*object, "poseCorrectives");
        DPL_TRY(const uint64_t encoding, fields.number("encoding", 0xffffffffu));
        if (encoding != 1 && encoding != 2)
            return fail(Code::Version, "pose corrective encoding {}; this build reads 1 and 2: update Doppel or export again", encoding);
        PoseCorrectiveData head;
        DPL_TRY(const uint64_t modes, fields.number("modeCount", kMaxCorrectiveModes));
        DPL_TRY(const uint64_t nodes, fields.number("nodeCount", kMaxCorrectiveNodes));
        if (nodes == 0 || modes == 0) return fail(Code::CorruptData, "pose correctives without nodes or modes");
        head.modeCount = uint32_t(modes), head.nodeCount = uint32_t(nodes);
        DPL_TRY(head.joints, fields.numbers("joints", limits.maxJoints, limits.maxJoints - 1));
        DPL_TRY(head.reach, fields.real("reach"));
        if (fields.has("reachOffModes")) {
            DPL_TRY(head.reachOffModes, fields.real("reachOffModes"));
        }
        DPL_TRY(head.motion, readMotionModes(fields));
        DPL_TRY(const Json* streams, fields.object("streams"));
        CorrectiveStreams<std::span<const uint8_t>> in;
        DPL_TRY(in.mean, stream(*streams, "mean"));
        DPL_TRY(in.modes, stream(*streams, "modes"));
        DPL_TRY(in.ranges, stream(*streams, "ranges"));
        DPL_TRY(in.nodes, stream(*streams, "nodes"));
        DPL_TRY(in.nodeIndices, stream(*streams, "nodeIndices"));
        DPL_TRY(in.nodeWeights, stream(*streams, "nodeWeights"));
        DPL_TRY(const auto coded, stream(*streams, "coded"));
        info.correctiveBytes += in.mean.size() + in.modes.size() + in.ranges.size() + in.nodes.size() + in.nodeIndices.size() +
                                in.nodeWeights.size() + coded.size();
        CorrectiveStreams<std::vector<uint8_t>> expanded;
        if (encoding == 2) {
            if (!in.nodes.empty() || !in.nodeIndices.empty() || !in.nodeWeights.empty())
                return fail(Code::CorruptData, "pose corrective encoding 2 beside streams of encoding 1");
            DPL_TRY(expanded, expandCorrectives(coded, head.columnCount(), head.nodeCount, avatar.mesh.restPositions.size()));
            in.nodes = expanded.nodes, in.nodeIndices = expanded.nodeIndices, in.nodeWeights = expanded.nodeWeights;
        } else if (!coded.empty()) {
            return fail(Code::CorruptData, "a stream of pose corrective encoding 2 in encoding 1");
        }
        DPL_TRY(avatar.correctives, decodeCorrectives(in, std::move(head), avatar.mesh.restPositions.size()));
        return {};
    }

    Status readLight() {
        const Fields root(extension, "DPL_gaussian_avatar");
        if (!root.has("light")) return {};
        if (info.version < 3) return fail(Code::CorruptData, "light in a file of version {}, which has none", info.version);
        DPL_TRY(const Json* object, root.object("light"));
        const Fields fields(*object, "light");
        DPL_TRY(const uint64_t encoding, fields.number("encoding", 0xffffffffu));
        if (encoding != 1) return fail(Code::Version, "light encoding {}; this build reads 1: update Doppel or export again", encoding);
        DPL_TRY(const std::vector<float> irradiance, fields.reals("irradiance", kIrradianceCoefficients));
        if (irradiance.size() != kIrradianceCoefficients)
            return fail(Code::CorruptData, "light with {} coefficients, not {}", irradiance.size(), kIrradianceCoefficients);
        std::copy(irradiance.begin(), irradiance.end(), avatar.light.irradiance.begin());
        return {};
    }

    /** A stream that is absent is empty: glTF has no empty buffer views. */
    Result<std::span<const uint8_t>> stream(const Json& streams, const char* name) {
        if (!streams.contains(name)) return std::span<const uint8_t>();
        DPL_TRY(const uint64_t view, Fields(streams, "streams").number(name, 0xffffffffu));
        if (view >= model.views.size())
            return fail(Code::CorruptData, "stream '{}' names buffer view {}, there are {}", name, view, model.views.size());
        DPL_RETURN_IF_ERROR(spend(model.views[view].length));
        return model.viewBytes(uint32_t(view));
    }

    Status read(std::span<const uint8_t> bytes) {
        DPL_RETURN_IF_ERROR(open(bytes));
        DPL_RETURN_IF_ERROR(taskAt(0.2));
        DPL_RETURN_IF_ERROR(readHead());
        DPL_RETURN_IF_ERROR(readJoints());
        DPL_RETURN_IF_ERROR(readLayers());
        DPL_RETURN_IF_ERROR(taskAt(0.5));
        DPL_RETURN_IF_ERROR(readSplats());
        DPL_RETURN_IF_ERROR(taskAt(0.9));
        DPL_RETURN_IF_ERROR(readCorrectives());
        DPL_RETURN_IF_ERROR(readLight());
        const Fields root(extension, "DPL_gaussian_avatar");
        const auto view = [&](const Json& streams, const char* name) { return stream(streams, name); };
        DPL_TRY(info.expressionBytes, readExpressions(root, view, avatar));
        DPL_TRY(info.captureMapBytes, readCaptureMap(root, view, avatar));
        // The reader accepts exactly what the writer may write.
        if (Status valid = checkAvatarWithoutSplats(avatar); !valid)
            return fail(Code::CorruptData, "the file holds an impossible avatar: {}", valid.error().message);
        return {};
    }

    void finishInfo() {
        info.name = avatar.name, info.generator = avatar.generator, info.evidence = avatar.evidence,
        info.trainedPixelM = avatar.trainedPixelM;
        info.vertices = uint32_t(avatar.mesh.restPositions.size()), info.triangles = uint32_t(avatar.mesh.triangles.size());
        info.joints = uint32_t(avatar.joints.size()), info.layers = uint32_t(avatar.mesh.layers.size());
        info.clips = uint32_t(avatar.clips.size());
        for (const JointData& joint : avatar.joints) info.jointNames.push_back(joint.name);
        for (const ClipData& clip : avatar.clips)
            info.clipList.push_back({clip.name, clip.timesS.empty() ? 0 : double(clip.timesS.back()) - double(clip.timesS.front())});
        for (const LayerData& layer : avatar.mesh.layers) {
            LayerInfo entry{layer.name, layer.role, layer.triangleCount, 0};
            for (const SplatChunk& chunk : coded.chunks)  // chunks do not cross layers
                if (chunk.firstTriangle - layer.firstTriangle < layer.triangleCount) entry.splats += chunk.splatCount;
            info.layerList.push_back(std::move(entry));
        }
        info.correctiveModes = avatar.correctives.modeCount, info.motionModes = avatar.correctives.motion.columnCount();
        info.correctiveNodes = avatar.correctives.followsPose() ? avatar.correctives.nodeCount : 0, info.light = !avatar.light.empty();
        info.expressions = uint32_t(avatar.expressions.shapes.size());
        const uint64_t known = info.meshBytes + info.splatBytes + info.shBytes + info.correctiveBytes + info.expressionBytes +
                               info.captureMapBytes + info.clipBytes + info.skinBytes + info.jsonBytes;
        info.otherBytes = info.fileBytes - std::min(known, info.fileBytes);
    }
};

}  // namespace

Result<AvatarData> readAvatar(std::span<const uint8_t> bytes, const ReadLimits& limits) try {
    AvatarReader reader{limits};
    DPL_RETURN_IF_ERROR(reader.read(bytes));
    reader.avatar.splats = decodeSplats(reader.coded, reader.avatar.mesh.triangles.size());
    return std::move(reader.avatar);
} catch (const std::bad_alloc&) {
    return outOfMemory("read an avatar");
} catch (const std::exception& e) {
    return fail(Code::CorruptData, "the avatar cannot be read: {}", e.what());
}

Result<CodedAvatar> readCodedAvatar(std::span<const uint8_t> bytes, const ReadLimits& limits) try {
    AvatarReader reader{limits};
    DPL_RETURN_IF_ERROR(reader.read(bytes));
    return CodedAvatar{std::move(reader.avatar), std::move(reader.coded)};
} catch (const std::bad_alloc&) {
    return outOfMemory("read an avatar");
} catch (const std::exception& e) {
    return fail(Code::CorruptData, "the avatar cannot be read: {}", e.what());
}

Result<AvatarInfo> inspectAvatar(std::span<const uint8_t> bytes, const ReadLimits& limits) try {
    ReadLimits tolerant = limits;
    tolerant.verifyHash = false;
    AvatarReader reader{tolerant};
    DPL_RETURN_IF_ERROR(reader.read(bytes));
    reader.finishInfo();
    return std::move(reader.info);
} catch (const std::bad_alloc&) {
    return outOfMemory("read an avatar");
} catch (const std::exception& e) {
    return fail(Code::CorruptData, "the avatar cannot be read: {}", e.what());
}

Result<AvatarData> decodedAvatar(const AvatarData& avatar) {
    DPL_TRY(const std::vector<uint8_t> bytes, writeAvatar(avatar));
    return readAvatar(bytes);
}

}  // namespace dpl
