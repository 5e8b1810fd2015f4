// SPDX-License-Identifier: Apache-2.0
// Damaged and hostile avatar files: each must give an error with a text, never a crash or a huge allocation.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "tests/not_finite.h"
#include "tests/unit/format/glb_parts.h"
#include "tests/unit/format/sample_avatars.h"
#include "tests/unit/format/sample_correctives.h"

namespace dpl {
namespace {

using nlohmann::json;
using test::GlbParts;

constexpr const char* kOurs = "DPL_gaussian_avatar";

ReadLimits trusting() {
    ReadLimits limits;
    limits.verifyHash = false;  // so that the reader finds the damage itself, not the wrong hash
    return limits;
}

std::vector<uint8_t> goodFile(bool draco = true) {
    return *writeAvatar(test::withCorrectives(test::layeredAvatar(1, 1, 8, 3), 1, {.modes = 2, .nodes = 5}), {.draco = draco});
}
AvatarData tinyWithCorrectives() {
    AvatarData a = test::withCorrectives(test::tinyAvatar(), 1, {.modes = 2, .nodes = 3});
    a.captureMap = test::sampleCaptureMap(a.joints.size());
    return a;
}

void expectRefused(const char* what, std::span<const uint8_t> bytes, Code code = Code::CorruptData) {
    auto result = readAvatar(bytes, trusting());
    ASSERT_FALSE(result) << what << " was accepted";
    EXPECT_FALSE(result.error().message.empty()) << what;
    EXPECT_EQ(int(result.error().code), int(code)) << what << ": " << result.error().message;
}

struct Damage {
    const char* what;
    std::function<void(GlbParts&)> apply;
    Code code = Code::CorruptData;
    bool draco = true;
};

template <class T>
void put(std::span<uint8_t> bytes, size_t index, T value) {
    std::memcpy(bytes.data() + index * sizeof(T), &value, sizeof(T));
}
json& ours(GlbParts& p) {
    return p.json["extensions"][kOurs];
}
json& correctives(GlbParts& p) {
    return ours(p)["poseCorrectives"];
}
json& draco(GlbParts& p) {
    return p.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"];
}
size_t attribute(GlbParts& p, const char* name) {
    return p.json["meshes"][0]["primitives"][0]["attributes"][name].get<size_t>();
}

json nested(int depth) {
    json inner = json::array();
    for (int i = 1; i < depth; ++i) inner = json::array({std::move(inner)});
    return inner;
}

TEST(HostileAvatar, rejectList) {
    const std::vector<Damage> list = {
        {"extension missing", [](GlbParts& p) { p.json.erase("extensions"); }, Code::Unsupported},
        {"extension of a newer version", [](GlbParts& p) { ours(p)["version"] = 4; }, Code::Version},
        {"newer splat encoding", [](GlbParts& p) { ours(p)["splats"]["encoding"] = 4; }, Code::Version},
        {"words as encoding 3", [](GlbParts& p) { ours(p)["splats"]["encoding"] = 3; }},
        {"palette encoding without a palette", [](GlbParts& p) { ours(p)["splats"]["encoding"] = 2; }},
        {"SH code of -128", [](GlbParts& p) { p.stream("sh")[4] = 0x80; }},
        {"version 0", [](GlbParts& p) { ours(p)["version"] = 0; }},
        {"version as text", [](GlbParts& p) { ours(p)["version"] = "1"; }},
        {"inches", [](GlbParts& p) { ours(p)["units"] = "inch"; }, Code::Unsupported},
        {"unknown SH basis", [](GlbParts& p) { ours(p)["splats"]["shBasis"] = "other"; }, Code::Unsupported},
        {"trained pixel 0", [](GlbParts& p) { ours(p)["trainedPixelM"] = 0; }},
        {"trained pixel negative", [](GlbParts& p) { ours(p)["trainedPixelM"] = -0.002; }},
        {"trained pixel of a thousand kilometres", [](GlbParts& p) { ours(p)["trainedPixelM"] = 1e6; }},
        {"trained pixel above every float", [](GlbParts& p) { ours(p)["trainedPixelM"] = 1e300; }},
        {"trained pixel that is almost nothing", [](GlbParts& p) { ours(p)["trainedPixelM"] = 1e-30; }},
        {"trained pixel as text", [](GlbParts& p) { ours(p)["trainedPixelM"] = "fine"; }},
        {"trained pixel null", [](GlbParts& p) { ours(p)["trainedPixelM"] = nullptr; }},
        {"no hash", [](GlbParts& p) { ours(p).erase("contentHash"); }},
        {"required extension we do not know", [](GlbParts& p) { p.json["extensionsRequired"].push_back("EXT_meshopt_compression"); }, Code::Unsupported},
        {"external buffer", [](GlbParts& p) { p.json["buffers"][0]["uri"] = "../../etc/passwd"; }, Code::Unsupported},
        {"buffer longer than the chunk", [](GlbParts& p) { p.json["buffers"][0]["byteLength"] = p.bin.size() + 4; }},
        {"65 levels of JSON", [](GlbParts& p) { p.json["extras"] = nested(65); }},
        {"three million JSON values", [](GlbParts& p) { p.json["extras"] = std::vector<int>(3 << 20, 1); }},
        {"view at 2^40", [](GlbParts& p) { p.json["bufferViews"][1]["byteOffset"] = 1ull << 40; }},
        {"view of 2^40 bytes", [](GlbParts& p) { p.json["bufferViews"][1]["byteLength"] = 1ull << 40; }},
        {"view at -4", [](GlbParts& p) { p.json["bufferViews"][0]["byteOffset"] = -4; }},
        {"Draco view at 2^40", [](GlbParts& p) { p.json["bufferViews"][draco(p)["bufferView"].get<size_t>()]["byteOffset"] = 1ull << 40; }},
        {"Draco view 9999", [](GlbParts& p) { draco(p)["bufferView"] = 9999; }},
        {"Draco attribute 99", [](GlbParts& p) { draco(p)["attributes"]["JOINTS_0"] = 99; }},
        {"Draco attribute of other size", [](GlbParts& p) { draco(p)["attributes"]["POSITION"] = 2; }},
        {"Draco bytes without their magic", [](GlbParts& p) { p.view(draco(p)["bufferView"])[0] = 'X'; }},
        {"Draco face count raised", [](GlbParts& p) { p.view(draco(p)["bufferView"])[11] = 0xff, p.view(draco(p)["bufferView"])[12] = 0x7f; }},
        {"huge vertex count", [](GlbParts& p) { p.json["accessors"][attribute(p, "POSITION")]["count"] = 0x7fffffff; }},
        {"huge index count", [](GlbParts& p) { p.json["accessors"][p.json["meshes"][0]["primitives"][0]["indices"].get<size_t>()]["count"] = 3000000; }},
        {"accessor past its view", [](GlbParts& p) { p.json["accessors"][p.json["skins"][0]["inverseBindMatrices"].get<size_t>()]["count"] = 100000; }},
        {"accessor without a count", [](GlbParts& p) { p.json["accessors"][0].erase("count"); }},
        {"accessor with a text as view", [](GlbParts& p) { p.json["accessors"][0]["bufferView"] = "0"; }},
        {"view of a second buffer", [](GlbParts& p) { p.json["bufferViews"][0]["buffer"] = 1; }},
        {"view with a stride of 6", [](GlbParts& p) { p.json["bufferViews"][0]["byteStride"] = 6; }},
        {"primitive without attributes", [](GlbParts& p) { p.json["meshes"][0]["primitives"][0].erase("attributes"); }},
        {"attribute at -1", [](GlbParts& p) { p.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = -1; }},
        {"node with half a matrix", [](GlbParts& p) { p.json["nodes"][0]["matrix"] = {1, 0, 0, 0, 1, 0, 0, 0}; }},
        {"node with a text in its translation", [](GlbParts& p) { p.json["nodes"][0]["translation"] = {0, "1", 0}; }},
        {"nodes as an object", [](GlbParts& p) { p.json["nodes"] = json::object({{"0", 1}}); }},
        {"mesh that is a number", [](GlbParts& p) { p.json["meshes"][0] = 5; }},
        {"skin without joints", [](GlbParts& p) { p.json["skins"][0].erase("joints"); }},
        {"accessor of unknown type", [](GlbParts& p) { p.json["accessors"][0]["componentType"] = 5130; }},
        {"skin out of range", [](GlbParts& p) { ours(p)["skin"] = 7; }},
        {"layer mesh out of range", [](GlbParts& p) { ours(p)["layers"][0]["mesh"] = 77; }},
        {"layer twice", [](GlbParts& p) { for (int i = 0; i < 200; ++i) ours(p)["layers"].push_back(ours(p)["layers"][0]); }},
        {"unknown role", [](GlbParts& p) { ours(p)["layers"][0]["role"] = "shoe"; }},
        {"humanoid joint out of range", [](GlbParts& p) { ours(p)["humanoidBones"][0]["joint"] = 1000; }},
        {"one joint as two humanoid bones", [](GlbParts& p) { ours(p)["humanoidBones"].push_back({{"bone", "spine"}, {"joint", ours(p)["humanoidBones"][0]["joint"]}}); }},
        {"accessor maximum of 9e15", [](GlbParts& p) { p.json["accessors"][0]["max"] = {9007199254740991}; }},
        {"accessor minimum of -9e15", [](GlbParts& p) { p.json["accessors"][1]["min"] = {-9007199254740991.0}; }},
        {"accessor maximum as a text", [](GlbParts& p) { p.json["accessors"][0]["max"] = "1"; }},
        {"node child out of range", [](GlbParts& p) { p.json["nodes"][0]["children"].push_back(500); }},
        {"node with two parents", [](GlbParts& p) { p.json["nodes"][1]["children"].push_back(p.json["nodes"][0]["children"][0]); p.json["nodes"][2]["children"].push_back(p.json["nodes"][0]["children"][0]); }},
        {"node cycle", [](GlbParts& p) { for (auto& n : p.json["nodes"]) n.erase("children"); p.json["nodes"][1]["children"] = {2}; p.json["nodes"][2]["children"] = {1}; }},
        {"node transform not a number", [](GlbParts& p) { p.json["nodes"][1]["translation"] = {1e39, 0, 0}; }},
        {"joint elsewhere than its bind matrix", [](GlbParts& p) { p.json["nodes"][1]["translation"] = {5, 5, 5}; }},
        {"bind matrix NaN", [](GlbParts& p) { put(p.accessor(p.json["skins"][0]["inverseBindMatrices"]), 12, kNan); }},
        {"bind matrix turned", [](GlbParts& p) { put(p.accessor(p.json["skins"][0]["inverseBindMatrices"]), 1, 0.5f); }},
        {"clip time NaN", [](GlbParts& p) { put(p.accessor(p.json["animations"][0]["samplers"][0]["input"]), 1, kNan); }},
        {"clip times falling", [](GlbParts& p) { put(p.accessor(p.json["animations"][0]["samplers"][0]["input"]), 1, 100.0f); }},
        {"clip rotation zero", [](GlbParts& p) { auto view = p.accessor(p.json["animations"][0]["samplers"][0]["output"]); std::fill(view.begin(), view.end(), 0); }},
        {"clip sampler out of range", [](GlbParts& p) { p.json["animations"][0]["channels"][0]["sampler"] = 4000; }},
        {"clip that scales", [](GlbParts& p) { p.json["animations"][0]["channels"].back()["target"]["path"] = "scale"; }, Code::Unsupported},
        {"splat count 2^40", [](GlbParts& p) { ours(p)["splats"]["count"] = 1ull << 40; }},
        {"one splat too many", [](GlbParts& p) { ours(p)["splats"]["count"] = ours(p)["splats"]["count"].get<int>() + 1; }},
        {"negative splat count", [](GlbParts& p) { ours(p)["splats"]["count"] = -1; }},
        {"SH degree 4", [](GlbParts& p) { ours(p)["splats"]["shDegree"] = 4; }},
        {"SH degree without its stream", [](GlbParts& p) { ours(p)["splats"]["shDegree"] = 2; }},
        {"stream missing", [](GlbParts& p) { ours(p)["splats"]["streams"].erase("size"); }},
        {"stream view out of range", [](GlbParts& p) { ours(p)["splats"]["streams"]["size"] = 123456; }},
        {"CSR count raised", [](GlbParts& p) { p.stream("triangleCounts")[0] += 1; }},
        {"CSR counts swapped", [](GlbParts& p) { auto s = p.stream("triangleCounts"); for (size_t i = 1; i < s.size(); ++i) if (s[i] != s[i - 1]) { std::swap(s[i], s[i - 1]); } }},
        {"CSR varint without end", [](GlbParts& p) { for (auto& b : p.stream("triangleCounts")) b = 0xff; }},
        {"chunk first splat wrong", [](GlbParts& p) { put(p.stream("chunks"), 0, 1u); }},
        {"chunk triangle wrong", [](GlbParts& p) { put(p.stream("chunks"), 3, 0xffffffffu); }},
        {"chunk scale NaN", [](GlbParts& p) { put(p.stream("chunks"), 4, kNan); }},
        {"chunk scale range empty", [](GlbParts& p) { put(p.stream("chunks"), 5, 1e-9f); }},
        {"chunk colour infinite", [](GlbParts& p) { put(p.stream("chunks"), 9, std::numeric_limits<float>::infinity()); }},
        {"correctives in version 1", [](GlbParts& p) { ours(p)["version"] = 1; }},
        {"correctives that are no object", [](GlbParts& p) { correctives(p) = 7; }},
        {"newer corrective encoding", [](GlbParts& p) { correctives(p)["encoding"] = 3; }, Code::Version},
        {"correctives of streams as encoding 2", [](GlbParts& p) { correctives(p)["encoding"] = 2; }},
        {"no modes", [](GlbParts& p) { correctives(p)["modeCount"] = 0; }},
        {"2^40 modes", [](GlbParts& p) { correctives(p)["modeCount"] = 1ull << 40; }},
        {"65 modes", [](GlbParts& p) { correctives(p)["modeCount"] = 65; }},
        {"one mode too few", [](GlbParts& p) { correctives(p)["modeCount"] = 1; }},
        {"no nodes", [](GlbParts& p) { correctives(p)["nodeCount"] = 0; }},
        {"one node too many", [](GlbParts& p) { correctives(p)["nodeCount"] = 6; }},
        {"65535 nodes", [](GlbParts& p) { correctives(p)["nodeCount"] = 65535; }},
        {"2^32 nodes", [](GlbParts& p) { correctives(p)["nodeCount"] = 1ull << 32; }},
        {"reach missing", [](GlbParts& p) { correctives(p).erase("reach"); }},
        {"reach zero", [](GlbParts& p) { correctives(p)["reach"] = 0; }},
        {"reach negative", [](GlbParts& p) { correctives(p)["reach"] = -1.5; }},
        {"reach off the modes zero", [](GlbParts& p) { correctives(p)["reachOffModes"] = 0; }},
        {"reach off the modes as text", [](GlbParts& p) { correctives(p)["reachOffModes"] = "far"; }},
        {"reach off the modes above every float", [](GlbParts& p) { correctives(p)["reachOffModes"] = 1e300; }},
        {"reach above every float", [](GlbParts& p) { correctives(p)["reach"] = 1e300; }},
        {"feature joints missing", [](GlbParts& p) { correctives(p).erase("joints"); }},
        {"feature joint out of range", [](GlbParts& p) { correctives(p)["joints"].back() = 8; }},
        {"feature joint negative", [](GlbParts& p) { correctives(p)["joints"][0] = -1; }},
        {"feature joint 2^40", [](GlbParts& p) { correctives(p)["joints"].back() = 1ull << 40; }},
        {"feature joints not rising", [](GlbParts& p) { correctives(p)["joints"][1] = 0; }},
        {"feature joints as text", [](GlbParts& p) { correctives(p)["joints"][0] = "hips"; }},
        {"5000 feature joints", [](GlbParts& p) { for (int j = 0; j < 5000; ++j) correctives(p)["joints"].push_back(j); }},
        {"corrective streams missing", [](GlbParts& p) { correctives(p).erase("streams"); }},
        {"corrective mean missing", [](GlbParts& p) { correctives(p)["streams"].erase("mean"); }},
        {"corrective ranges missing", [](GlbParts& p) { correctives(p)["streams"].erase("ranges"); }},
        {"corrective nodes missing", [](GlbParts& p) { correctives(p)["streams"].erase("nodes"); }},
        {"corrective indices missing", [](GlbParts& p) { correctives(p)["streams"].erase("nodeIndices"); }},
        {"corrective weights missing", [](GlbParts& p) { correctives(p)["streams"].erase("nodeWeights"); }},
        {"corrective stream out of range", [](GlbParts& p) { correctives(p)["streams"]["modes"] = 123456; }},
        {"corrective stream of other length", [](GlbParts& p) { correctives(p)["streams"]["modes"] = correctives(p)["streams"]["mean"]; }},
        {"corrective mean NaN", [](GlbParts& p) { put(p.correctiveStream("mean"), 3, kNan); }},
        {"corrective mode infinite", [](GlbParts& p) { put(p.correctiveStream("modes"), 3, std::numeric_limits<float>::infinity()); }},
        {"corrective mode of 1e30", [](GlbParts& p) { put(p.correctiveStream("modes"), 3, 1e30f); }},
        {"corrective range NaN", [](GlbParts& p) { put(p.correctiveStream("ranges"), 7, kNan); }},
        {"corrective range of 1e30 m", [](GlbParts& p) { put(p.correctiveStream("ranges"), 0, 1e30f); }},
        {"corrective node out of range", [](GlbParts& p) { put(p.correctiveStream("nodeIndices"), 9, uint16_t(5)); }},
        {"corrective weights not summing to 255", [](GlbParts& p) { p.correctiveStream("nodeWeights")[4] ^= 1; }},
        {"index out of range", [](GlbParts& p) { put(p.accessor(p.json["meshes"][0]["primitives"][0]["indices"]), 4, 70000u); }, Code::CorruptData, false},
        {"vertex NaN", [](GlbParts& p) { put(p.accessor(attribute(p, "POSITION")), 5, kNan); }, Code::CorruptData, false},
        {"vertex a kilometre away", [](GlbParts& p) { put(p.accessor(attribute(p, "POSITION")), 5, 1000.0f); }, Code::CorruptData, false},
        {"weights not summing to 255", [](GlbParts& p) { p.accessor(attribute(p, "WEIGHTS_0"))[0] ^= 1; }, Code::CorruptData, false},
        {"joint out of range", [](GlbParts& p) { p.accessor(attribute(p, "JOINTS_0"))[0] = 200; }, Code::CorruptData, false},
        {"attributes of different counts", [](GlbParts& p) { p.json["accessors"][attribute(p, "COLOR_0")]["count"] = 3; }, Code::CorruptData, false},
        {"indices not whole triangles", [](GlbParts& p) { auto& c = p.json["accessors"][p.json["meshes"][0]["primitives"][0]["indices"].get<size_t>()]["count"]; c = c.get<int>() - 1; }, Code::CorruptData, false},
        {"no positions", [](GlbParts& p) { p.json["meshes"][0]["primitives"][0]["attributes"].erase("POSITION"); }, Code::CorruptData, false},
    };
    for (const Damage& damage : list) {
        GlbParts parts = test::split(goodFile(damage.draco));
        damage.apply(parts);
        expectRefused(damage.what, parts.bytes(), damage.code);
    }
}

TEST(HostileAvatar, damagedMotionModes) {
    const auto motion = [](GlbParts& p) -> json& { return correctives(p)["motion"]; };
    const auto bytesOf = [motion](GlbParts& p, const char* name) { return p.view(motion(p)["streams"][name].get<size_t>()); };
    const std::vector<Damage> list = {
        {"in version 2", [](GlbParts& p) { ours(p)["version"] = 2; }},
        {"a number", [=](GlbParts& p) { motion(p) = 7; }},
        {"newer encoding", [=](GlbParts& p) { motion(p)["encoding"] = 2; }, Code::Version},
        {"no encoding", [=](GlbParts& p) { motion(p).erase("encoding"); }},
        {"joints missing", [=](GlbParts& p) { motion(p).erase("joints"); }},
        {"joints empty", [=](GlbParts& p) { motion(p)["joints"] = json::array(); }},
        {"joint out of range", [=](GlbParts& p) { motion(p)["joints"][0] = 2; }},
        {"13 joints",
         [=](GlbParts& p) {
             for (int j = 0; j < 13; ++j) motion(p)["joints"].push_back(j);
         }},
        {"moved from as text", [=](GlbParts& p) { motion(p)["movedFrom"] = "0"; }},
        {"moved to missing", [=](GlbParts& p) { motion(p).erase("movedTo"); }},
        {"moved to of 1e300", [=](GlbParts& p) { motion(p)["movedTo"] = 1e300; }},
        {"moved to below from", [=](GlbParts& p) { motion(p)["movedTo"] = 0.0625; }},
        {"holds missing", [=](GlbParts& p) { motion(p).erase("holds"); }},
        {"no holds", [=](GlbParts& p) { motion(p)["holds"] = json::array(); }},
        {"4 holds",
         [=](GlbParts& p) {
             motion(p)["holds"] = {1, 2, 3, 4};
         }},
        {"hold as text", [=](GlbParts& p) { motion(p)["holds"][0] = "1"; }},
        {"hold negative", [=](GlbParts& p) { motion(p)["holds"][0] = -1; }},
        {"hold of 1e300", [=](GlbParts& p) { motion(p)["holds"][0] = 1e300; }},
        {"4 lags",
         [=](GlbParts& p) {
             motion(p)["lags"] = {1, 2, 3, 4};
         }},
        {"a lag without modes", [=](GlbParts& p) { motion(p)["lags"] = {1}; }},
        {"lags as text", [=](GlbParts& p) { motion(p)["lags"] = "1"; }},
        {"streams missing", [=](GlbParts& p) { motion(p).erase("streams"); }},
        {"still missing", [=](GlbParts& p) { motion(p)["streams"].erase("still"); }},
        {"ranges out of range", [=](GlbParts& p) { motion(p)["streams"]["ranges"] = 123456; }},
        {"modes of other length", [=](GlbParts& p) { motion(p)["streams"]["modes"] = motion(p)["streams"]["still"]; }},
        {"groups missing", [=](GlbParts& p) { motion(p)["streams"].erase("groups"); }},
        {"groups of no whole length", [=](GlbParts& p) { motion(p)["streams"]["groups"] = motion(p)["streams"]["still"]; }},
        {"no columns", [=](GlbParts& p) { put(bytesOf(p, "groups"), 0, 0u); }},
        {"one column too many", [=](GlbParts& p) { put(bytesOf(p, "groups"), 0, 2u); }},
        {"2^32 - 1 columns", [=](GlbParts& p) { put(bytesOf(p, "groups"), 0, 0xffffffffu); }},
        {"63 columns", [=](GlbParts& p) { put(bytesOf(p, "groups"), 0, 63u); }},
        {"reach infinite", [=](GlbParts& p) { put(bytesOf(p, "groups"), 3, kInfinity); }},
        {"still NaN", [=](GlbParts& p) { put(bytesOf(p, "still"), 0, kNan); }},
        {"still zero",
         [=](GlbParts& p) {
             auto s = bytesOf(p, "still");
             std::fill(s.begin(), s.end(), uint8_t(0));
         }},
        {"rest negative", [=](GlbParts& p) { put(bytesOf(p, "ranges"), 0, -0.5f); }},
        {"most of a thousand turns", [=](GlbParts& p) { put(bytesOf(p, "ranges"), 1, 6283.0f); }},
        {"mode infinite", [=](GlbParts& p) { put(bytesOf(p, "modes"), 3, kInfinity); }},
    };
    const std::vector<uint8_t> good = *writeAvatar(test::tinyMovingAvatar());
    for (const Damage& damage : list) {
        GlbParts parts = test::split(good);
        damage.apply(parts);
        expectRefused(damage.what, parts.bytes(), damage.code);
    }
    EXPECT_TRUE(readAvatar(test::split(good).bytes(), trusting()));
}

TEST(HostileAvatar, damagedLight) {
    const auto light = [](GlbParts& p) -> json& { return ours(p)["light"]; };
    const std::vector<Damage> list = {
        {"in version 2", [](GlbParts& p) { ours(p)["version"] = 2; }},
        {"a number", [=](GlbParts& p) { light(p) = 7; }},
        {"newer encoding", [=](GlbParts& p) { light(p)["encoding"] = 2; }, Code::Version},
        {"no encoding", [=](GlbParts& p) { light(p).erase("encoding"); }},
        {"no coefficients", [=](GlbParts& p) { light(p).erase("irradiance"); }},
        {"7 coefficients", [=](GlbParts& p) { light(p)["irradiance"].erase(7); }},
        {"9 coefficients", [=](GlbParts& p) { light(p)["irradiance"].push_back(0); }},
        {"a coefficient as text", [=](GlbParts& p) { light(p)["irradiance"][2] = "0"; }},
        {"a coefficient of 4.1", [=](GlbParts& p) { light(p)["irradiance"][2] = 4.1; }},
        {"a coefficient of 1e300", [=](GlbParts& p) { light(p)["irradiance"][2] = 1e300; }},
    };
    const std::vector<uint8_t> good = *writeAvatar(test::tinyLitAvatar());
    for (const Damage& damage : list) {
        GlbParts parts = test::split(good);
        damage.apply(parts);
        expectRefused(damage.what, parts.bytes(), damage.code);
    }
    EXPECT_TRUE(readAvatar(test::split(good).bytes(), trusting()));
}

TEST(HostileAvatar, damagedPalettes) {
    const std::vector<Damage> list = {
        {"size missing", [](GlbParts& p) { ours(p)["splats"].erase("shPaletteSize"); }},
        {"size 0", [](GlbParts& p) { ours(p)["splats"]["shPaletteSize"] = 0; }},
        {"size 2^40", [](GlbParts& p) { ours(p)["splats"]["shPaletteSize"] = 1ull << 40; }},
        {"size 65537", [](GlbParts& p) { ours(p)["splats"]["shPaletteSize"] = 65537; }},
        {"one entry too many", [](GlbParts& p) { ours(p)["splats"]["shPaletteSize"] = ours(p)["splats"]["shPaletteSize"].get<int>() + 1; }},
        {"palette read as encoding 1", [](GlbParts& p) { ours(p)["splats"]["encoding"] = 1; }},
        {"indices missing", [](GlbParts& p) { ours(p)["splats"]["streams"].erase("shIndex"); }},
        {"indices of other length", [](GlbParts& p) { ours(p)["splats"]["streams"]["shIndex"] = ours(p)["splats"]["streams"]["place"]; }},
        {"index out of range", [](GlbParts& p) { put(p.stream("shIndex"), 5, uint16_t(0xffff)); }},
        {"index one out of range", [](GlbParts& p) { put(p.stream("shIndex"), 0, ours(p)["splats"]["shPaletteSize"].get<uint16_t>()); }},
        {"SH degree 0", [](GlbParts& p) { ours(p)["splats"]["shDegree"] = 0; }},
        {"entry code of -128", [](GlbParts& p) { p.stream("sh")[0] = 0x80; }},
        {"a chunk with its own range", [](GlbParts& p) { put(p.stream("chunks"), 12 + 16, 0.75f); }},
        {"range NaN", [](GlbParts& p) { put(p.stream("chunks"), 12, kNan); }},
    };
    const std::vector<uint8_t> good = *writeAvatar(test::layeredAvatar(1, 1, 8, 8), {.shPalette = true});
    for (const Damage& damage : list) {
        GlbParts parts = test::split(good);
        ASSERT_GE(parts.stream("chunks").size(), 2u * 64);
        damage.apply(parts);
        expectRefused(damage.what, parts.bytes(), damage.code);
    }
    EXPECT_TRUE(readAvatar(test::split(good).bytes(), trusting()));
}

TEST(HostileAvatar, damagedCaptureMaps) {
    AvatarData mapped = test::tinyAvatar();
    mapped.captureMap = test::sampleCaptureMap(mapped.joints.size());
    const std::vector<uint8_t> good = *writeAvatar(mapped);
    const auto read = [&](const std::function<void(GlbParts&)>& damage) {
        GlbParts parts = test::split(good);
        damage(parts);
        return readAvatar(parts.bytes(), trusting());
    };
    const auto map = [](GlbParts& p) -> nlohmann::json& { return ours(p)["captureMap"]; };
    const auto sides = [&](GlbParts& p) { return p.view(map(p)["streams"]["sides"]); };
    ASSERT_TRUE(read([](GlbParts&) {}));
    const std::pair<const char*, std::function<void(GlbParts&)>> list[] = {
        {"a number", [&](GlbParts& p) { map(p) = 1; }},
        {"no encoding", [&](GlbParts& p) { map(p).erase("encoding"); }},
        {"encoding 0", [&](GlbParts& p) { map(p)["encoding"] = 0; }},
        {"encoding as text", [&](GlbParts& p) { map(p)["encoding"] = "1"; }},
        {"no streams", [&](GlbParts& p) { map(p).erase("streams"); }},
        {"no stream", [&](GlbParts& p) { map(p)["streams"].erase("sides"); }},
        {"view 9999", [&](GlbParts& p) { map(p)["streams"]["sides"] = 9999; }},
        {"a view of another length", [&](GlbParts& p) { map(p)["streams"]["sides"] = 0; }},
        {"a shorter view",
         [&](GlbParts& p) {
             auto& v = p.json["bufferViews"][map(p)["streams"]["sides"].get<size_t>()];
             v["byteLength"] = v["byteLength"].get<size_t>() - 1;
         }},
        {"detail finer than its pixel", [&](GlbParts& p) { sides(p)[1] = 1; }},
        {"a pixel without detail", [&](GlbParts& p) { sides(p)[1] = 0; }},
        {"pictures of what is not seen", [&](GlbParts& p) { sides(p)[8] = 3; }},
    };
    for (const auto& [what, damage] : list) {
        const auto result = read(damage);
        ASSERT_FALSE(result) << what;
        EXPECT_EQ(int(result.error().code), int(Code::CorruptData)) << what << ": " << result.error().message;
    }
    for (size_t size = 0; size < good.size(); ++size)
        ASSERT_FALSE(readAvatar(std::span(good).first(size), trusting())) << "cut to " << size << " bytes";
    // A map of a newer encoding is no reason not to show the avatar.
    const auto newer = read([&](GlbParts& p) { map(p) = {{"encoding", 2}, {"streams", "of another kind"}}; });
    ASSERT_TRUE(newer) << newer.error().message;
    EXPECT_TRUE(newer->captureMap.empty());
}

TEST(HostileAvatar, anUndamagedFilePassesTheSamePath) {
    for (bool compressed : {true, false}) {
        auto result = readAvatar(test::split(goodFile(compressed)).bytes(), trusting());
        ASSERT_TRUE(result) << result.error().message;
    }
}

TEST(HostileAvatar, containerHeader) {
    std::vector<uint8_t> good = goodFile(), bad = good;
    bad[0] = 'x';
    expectRefused("bad magic", bad, Code::Unsupported);
    bad = good, bad[4] = 1;
    expectRefused("container version 1", bad, Code::Unsupported);
    bad = good, bad[8] ^= 4;
    expectRefused("length differs from the file", bad);
    bad = good, bad.push_back(0);
    expectRefused("something appended", bad);
    bad = good, bad[15] = 0x7f;
    expectRefused("JSON chunk longer than the file", bad);
    bad = good, bad[16] = 'B';
    expectRefused("first chunk is not JSON", bad);
    expectRefused("nothing", {});
}

TEST(HostileAvatar, fortyKilobytesOfBrackets) {
    GlbParts parts;
    expectRefused("nested arrays",
                  parts.join("{\"asset\":{\"version\":\"2.0\"},\"a\":" + std::string(20000, '[') + std::string(20000, ']') + "}"));
    expectRefused("nested objects", parts.join("{\"asset\":" + [] {
        std::string s;
        for (int i = 0; i < 8000; ++i) s += "{\"a\":";
        return s + "1" + std::string(8000, '}');
    }() + "}"));
    expectRefused("brackets that never close", parts.join(std::string(40000, '[')));
    expectRefused("number too large", parts.join("{\"asset\":{\"version\":\"2.0\"},\"a\":1e999}"));
    expectRefused("no JSON at all", parts.join("hello"));
}

void expectTruncationsRefused(const AvatarData& avatar) {
    const std::vector<uint8_t> good = *writeAvatar(avatar);
    for (size_t size = 0; size < good.size(); ++size) ASSERT_FALSE(readAvatar(std::span(good).first(size))) << size;
    // The same with corrected lengths in the header and the last chunk, so that the inner checks are reached.
    GlbParts parts = test::split(good);
    for (size_t cut = parts.bin.size() - 4; cut > 4; cut -= 4) {
        GlbParts shorter = parts;
        shorter.bin.resize(cut);
        ASSERT_FALSE(readAvatar(shorter.bytes(), trusting())) << cut;
        shorter.json["buffers"][0]["byteLength"] = cut;
        ASSERT_FALSE(readAvatar(shorter.bytes(), trusting())) << cut;
    }
}

TEST(HostileAvatar, everyTruncationIsAnError) {
    expectTruncationsRefused(test::tinyAvatar());
    expectTruncationsRefused(tinyWithCorrectives());
}

TEST(HostileAvatar, everyBitFlipIsNoticed) {
    std::vector<uint8_t> bytes = *writeAvatar(tinyWithCorrectives());
    for (size_t bit = 0; bit < bytes.size() * 8; bit += 15) {  // about every second byte, at varying bits, to keep the test at seconds
        bytes[bit / 8] ^= uint8_t(1 << bit % 8);
        ASSERT_FALSE(readAvatar(bytes)) << "bit " << bit % 8 << " of byte " << bit / 8;
        bytes[bit / 8] ^= uint8_t(1 << bit % 8);
    }
}

TEST(HostileAvatar, bitFlipsWithoutTheHashNeverGiveAnAvatarThatCannotBeWritten) {
    for (bool compressed : {true, false}) {
        std::vector<uint8_t> bytes = *writeAvatar(tinyWithCorrectives(), {.draco = compressed});
        for (size_t bit = 0; bit < bytes.size() * 8; bit += 29) {
            bytes[bit / 8] ^= uint8_t(1 << bit % 8);
            if (auto result = readAvatar(bytes, trusting())) {
                ASSERT_TRUE(writeAvatar(*result)) << "bit " << bit;
            }
            bytes[bit / 8] ^= uint8_t(1 << bit % 8);
        }
    }
}

TEST(HostileAvatar, inspectReportsAWrongHash) {
    GlbParts parts = test::split(goodFile());
    parts.json["scenes"][0]["name"] = "somebody edited this";
    auto info = inspectAvatar(parts.bytes());
    ASSERT_TRUE(info) << info.error().message;
    EXPECT_FALSE(info->hashMatches);
    EXPECT_FALSE(readAvatar(parts.bytes()));
}

TEST(WriterRefuses, whatNoReaderWouldAccept) {
    auto refused = [](const char* what, std::function<void(AvatarData&)> damage) {
        AvatarData a = test::layeredAvatar(2, 1, 6, 2);
        damage(a);
        auto result = writeAvatar(a);
        ASSERT_FALSE(result) << what;
        EXPECT_EQ(int(result.error().code), int(Code::InvalidArgument)) << what;
    };
    refused("no joints", [](AvatarData& a) { a.joints.clear(); });
    refused("second root", [](AvatarData& a) { a.joints[2].parent = -1; });
    refused("child before parent", [](AvatarData& a) { a.joints[1].parent = 3; });
    refused("NaN vertex", [](AvatarData& a) { a.mesh.restPositions[3].y = kNan; });
    refused("far vertex", [](AvatarData& a) { a.mesh.restPositions[3].y = 180; });
    refused("weights", [](AvatarData& a) { a.mesh.jointWeights[0].x ^= 1; });
    refused("joint index", [](AvatarData& a) { a.mesh.jointIndices[0].x = 6; });
    refused("layer gap", [](AvatarData& a) { a.mesh.layers[1].firstVertex += 1; });
    refused("triangle across layers", [](AvatarData& a) { a.mesh.triangles[0].x = uint32_t(a.mesh.restPositions.size() - 1); });
    refused("CSR falling", [](AvatarData& a) { a.splats.triangleStart[3] = 0xffffffff; });
    refused("splat NaN", [](AvatarData& a) { a.splats.uv[0].x = kNan; });
    refused("negative scale", [](AvatarData& a) { a.splats.scaleM[0].x = -1; });
    refused("SH length", [](AvatarData& a) { a.splats.sh.pop_back(); });
    refused("clip times", [](AvatarData& a) { a.clips[0].timesS[1] = 0; });
    auto refusedCorrectives = [&](const char* what, std::function<void(PoseCorrectiveData&)> damage) {
        refused(what, [&](AvatarData& a) { a.correctives = test::randomCorrectives(a, 1), damage(a.correctives); });
    };
    refusedCorrectives("corrective weights", [](PoseCorrectiveData& c) { c.nodeWeights[0].x ^= 1; });
    refusedCorrectives("corrective node", [](PoseCorrectiveData& c) { c.nodeIndices[0].x = 12; });
    refusedCorrectives("corrective NaN", [](PoseCorrectiveData& c) { c.nodes[0].w = kNan; });
    refusedCorrectives("corrective joint", [](PoseCorrectiveData& c) { c.joints.back() = 6; });
    refused("capture map of another rig", [](AvatarData& a) { a.captureMap = test::sampleCaptureMap(5); });
    const auto refusedSide = [&](const char* what, CaptureSide side) {
        refused(what, [&](AvatarData& a) { a.captureMap = test::sampleCaptureMap(6), a.captureMap.sides[7] = side; });
    };
    refusedSide("capture NaN", {kNan, kNan, 1});
    refusedSide("capture negative", {-0.001f, 0.001f, 1});
    refusedSide("capture infinite", {0.001f, std::numeric_limits<float>::infinity(), 1});
    refusedSide("detail finer than its pixel", {0.002f, 0.001f, 1});
    refusedSide("detail without a pixel", {0, 0.001f, 1});
    refusedSide("pictures of what is not seen", {0, 0, 1});
    refused("clip rotation", [](AvatarData& a) { a.clips[0].channels[0].rotations[0] = Quatf(0, 0, 0, 0); });
}

}  // namespace
}  // namespace dpl
