// SPDX-License-Identifier: Apache-2.0
// One motion under other names, rest poses, axes, containers and flaws moves an avatar as the plain file does.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

#include "sdk/core/log.h"
#include "sdk/motion/clip.h"
#include "sdk/motion/motion_clip.h"
#include "tests/not_finite.h"
#include "tests/unit/motion/mocap.h"
#include "tests/unit/motion/written_motion.h"

namespace dpl {
namespace {

using test::bvhOf;
using test::glbOf;
using test::jointOf;
using test::personRig;
using test::positionsAt;
using test::Writing;
using test::WrittenMotion;

/** A person of other build than the avatar, in T-pose. */
std::vector<JointData> personOfFile() {
    auto rig = personRig(0.0f, 0.0f);
    for (JointData& joint : rig) joint.restPosition *= Vec3f(0.82f, 0.86f, 0.86f);
    return rig;
}

/** A walk of 1 s. bentKeys: so many first keys bow by `bowRad`. */
std::vector<Pose> walk(const std::vector<JointData>& rig, size_t bentKeys = 0, float bowRad = 1.05f) {
    std::vector<Pose> poses;
    for (size_t k = 0; k < 30; ++k) {
        Pose pose = test::swing(rig, double(k) / 30.0);
        if (k < bentKeys) {
            const size_t spine = jointOf(rig, "spine");
            pose.localRotations[spine] = pose.localRotations[spine] * glm::angleAxis(bowRad, Vec3f(1, 0, 0));
        }
        poses.push_back(pose);
    }
    return poses;
}

std::span<const uint8_t> bytesOf(const std::string& text) {
    return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

/** What readClip says while it lives. */
class Notes {
public:
    Notes() {
        setLogSink([this](LogLevel, std::string_view text) { text_ += std::string(text) + "\n"; });
    }
    ~Notes() { setLogSink({}); }
    const std::string& text() const { return text_; }
    bool has(std::string_view part) const { return text_.find(part) != std::string::npos; }

private:
    std::string text_;
};

ClipData played(std::span<const uint8_t> bytes, const std::string& name, const MotionChoice& choice = {}) {
    RetargetOptions options;
    options.keepLeadIn = true;
    options.plantFeet = options.levelHead = false;
    auto clip = readClip(bytes, name, choice, personRig(0.8f), options);
    EXPECT_TRUE(clip) << clip.error().message;
    return clip ? std::move(*clip) : ClipData();
}

std::string refused(std::span<const uint8_t> bytes, const MotionChoice& choice = {}) {
    auto clip = readClip(bytes, "a file", choice, personRig(0.8f));
    EXPECT_FALSE(clip);
    return clip ? std::string() : clip.error().message;
}

constexpr const char* kShown[] = {"hips",     "upperChest",    "head",          "leftUpperArm", "leftLowerArm",
                                  "leftHand", "rightUpperArm", "rightLowerArm", "rightHand",    "leftLowerLeg",
                                  "leftFoot", "rightLowerLeg", "rightFoot"};

/** Largest distance between the same joints of two clips at the same times, metres, relative to the hips. */
float farthestApart(const ClipData& a, const ClipData& b) {
    const auto rig = personRig(0.8f);
    float worst = 0;
    if (a.timesS.empty() || b.timesS.empty()) return 1e9f;
    for (double t = 0; t <= std::min(clipDurationS(a), clipDurationS(b)); t += 1.0 / 30) {
        const auto pa = positionsAt(a, rig, t), pb = positionsAt(b, rig, t);
        const size_t hips = jointOf(rig, "hips");
        for (const char* bone : kShown) {
            const size_t j = jointOf(rig, bone);
            worst = std::max(worst, glm::length((pa[j] - pa[hips]) - (pb[j] - pb[hips])));
        }
    }
    return worst;
}

ClipData plain(size_t bentKeys = 0) {
    const auto rig = personOfFile();
    return played(bytesOf(bvhOf(WrittenMotion(rig, walk(rig, bentKeys), {}))), "plain.bvh");
}

/** Names by bone of programs and of nobody. Bones that a table lacks keep their humanoid names, which no test depends on. */
std::string soma(const std::string& bone) {
    static const std::map<std::string, std::string> names = {
        {"hips", "Hips"},    {"spine", "Spine1"},      {"chest", "Spine2"}, {"upperChest", "Chest"}, {"neck", "Neck1"},
        {"head", "Head"},    {"Shoulder", "Shoulder"}, {"UpperArm", "Arm"}, {"LowerArm", "ForeArm"}, {"Hand", "Hand"},
        {"UpperLeg", "Leg"}, {"LowerLeg", "Shin"},     {"Foot", "Foot"},    {"Toes", "ToeBase"}};
    const std::string side = bone.starts_with("left") ? "Left" : bone.starts_with("right") ? "Right" : "";
    const auto found = names.find(bone.substr(side.size()));
    return found == names.end() ? bone : side + found->second;
}
std::string theia(const std::string& bone) {
    static const std::map<std::string, std::string> names = {
        {"hips", "pelvis"},    {"spine", "torso"},    {"chest", "torso_2"}, {"upperChest", "torso_3"}, {"neck", "neck"},
        {"head", "head"},      {"Shoulder", "clav"},  {"UpperArm", "uarm"}, {"LowerArm", "larm"},      {"Hand", "hand"},
        {"UpperLeg", "thigh"}, {"LowerLeg", "shank"}, {"Foot", "foot"},     {"Toes", "toes"}};
    const std::string side = bone.starts_with("left") ? "left" : bone.starts_with("right") ? "right" : "";
    const auto found = names.find(bone.substr(side.size()));
    return found == names.end() ? bone : (side.empty() ? "" : side.substr(0, 1) + "_") + found->second;
}
std::string optiTrack(const std::string& bone) {
    static const std::map<std::string, std::string> names = {
        {"hips", "Hip"},       {"spine", "Ab"},          {"chest", "Ab2"},     {"upperChest", "Chest"}, {"neck", "Neck"},
        {"head", "Head"},      {"Shoulder", "Shoulder"}, {"UpperArm", "UArm"}, {"LowerArm", "FArm"},    {"Hand", "Hand"},
        {"UpperLeg", "Thigh"}, {"LowerLeg", "Shin"},     {"Foot", "Foot"},     {"Toes", "Toe"}};
    const std::string side = bone.starts_with("left") ? "left" : bone.starts_with("right") ? "right" : "";
    const auto found = names.find(bone.substr(side.size()));
    return found == names.end() ? bone : (side.empty() ? "" : side == "left" ? "L" : "R") + found->second;
}
std::string japanese(const std::string& bone) {
    static const std::map<std::string, std::string> names = {
        {"hips", "下半身"}, {"spine", "上半身"},  {"chest", "上半身2"}, {"upperChest", "上半身3"}, {"neck", "首"},
        {"head", "頭"},     {"Shoulder", "肩"},   {"UpperArm", "腕"},   {"LowerArm", "ひじ"},      {"Hand", "手首"},
        {"UpperLeg", "足"}, {"LowerLeg", "ひざ"}, {"Foot", "足首"},     {"Toes", "つま先"}};
    const std::string side = bone.starts_with("left") ? "left" : bone.starts_with("right") ? "right" : "";
    const auto found = names.find(bone.substr(side.size()));
    return (side.empty() ? "" : side == "left" ? "左" : "右") + (found == names.end() ? bone.substr(side.size()) : found->second);
}
std::string numbered(const std::string& bone) {
    const auto all = humanoidBoneNames();
    return formatText("Bone_{}", std::find(all.begin(), all.end(), bone) - all.begin());
}

struct NamedWriting {
    const char* what;
    Writing how;
};

std::vector<NamedWriting> manyNames() {
    return {{"soma", {soma}}, {"theia", {theia}}, {"optitrack", {optiTrack}}, {"japanese", {japanese}}, {"numbered", {numbered}}};
}

TEST(MotionInputs, namesThatNobodyKnowsAreRecognisedByTheTree) {
    const auto rig = personOfFile();
    const ClipData right = plain();
    const Quatf about(glm::angleAxis(glm::pi<float>(), Vec3f(0, 1, 0))), zUp(glm::angleAxis(glm::half_pi<float>(), Vec3f(1, 0, 0)));
    for (NamedWriting names : manyNames())
        for (const auto& [axes, turned] : {std::pair("y up", Quatf(1, 0, 0, 0)), {"y up, faces -z", about}, {"z up", zUp}}) {
            SCOPED_TRACE(std::string(names.what) + ", " + axes);
            names.how.turned = turned;
            Notes notes;
            const ClipData clip = played(bytesOf(bvhOf(WrittenMotion(rig, walk(rig), names.how))), "names.bvh");
            EXPECT_LT(farthestApart(clip, right), 2e-3f) << "metres; angles are written with 6 digits";
            EXPECT_FALSE(notes.has("does not drive")) << notes.text();
        }
}

TEST(MotionInputs, sidesFollowFromThePositionsWhereNamesTellNone) {
    // Numbers in the order of the right side first: only positions and feet can tell.
    auto rig = personOfFile();
    for (JointData& joint : rig) {
        std::string& bone = joint.humanoidBone;
        if (bone.starts_with("left"))
            bone = "right" + bone.substr(4);
        else if (bone.starts_with("right"))
            bone = "left" + bone.substr(5);
    }
    for (JointData& joint : rig) joint.restPosition.x *= -1;  // the person itself is the same: left is +x again
    const ClipData a = played(bytesOf(bvhOf(WrittenMotion(rig, walk(rig), {numbered}))), "numbers.bvh");
    for (JointData& joint : rig) joint.name.clear();
    std::vector<JointData> named = rig;
    const ClipData b = played(bytesOf(bvhOf(WrittenMotion(named, walk(rig), {[](const std::string& bone) { return bone; }}))), "named.bvh");
    EXPECT_LT(farthestApart(a, b), 2e-3f);
}

TEST(MotionInputs, limbsThatNothingDrivesAreNamed) {
    auto rig = personOfFile();
    std::erase_if(rig, [](const JointData& j) {
        return j.humanoidBone.starts_with("left") && j.parent >= 0 && j.restPosition.y > 1.1f && j.restPosition.x > 0.3f;
    });
    // The left arm ends above the elbow; parents before it keep their indices, those behind it are looked up anew.
    auto whole = personOfFile();
    for (JointData& joint : rig) {
        const auto old = std::find_if(whole.begin(), whole.end(), [&](const JointData& j) { return j.name == joint.name; });
        if (old->parent < 0) continue;
        const std::string parent = whole[size_t(old->parent)].name;
        joint.parent = int32_t(std::find_if(rig.begin(), rig.end(), [&](const JointData& j) { return j.name == parent; }) - rig.begin());
    }
    Notes notes;
    const ClipData clip = played(bytesOf(bvhOf(WrittenMotion(rig, walk(rig), {}))), "stump.bvh");
    EXPECT_TRUE(notes.has("does not drive leftLowerArm, leftHand")) << notes.text();
    for (const ClipChannel& channel : clip.channels) EXPECT_NE(personRig(0.8f)[channel.joint].humanoidBone, "leftHand");
}

/** The rest pose that is made from a frame differs from the true one by what a T-pose leaves open: how far a trunk leans at rest. */
constexpr float kMadeRestM = 0.05f;

TEST(MotionInputs, aRestPoseThatDoesNotStandIsMadeFromTheFrameThatStandsBest) {
    const auto rig = personOfFile();
    const Quatf zUp(glm::angleAxis(glm::half_pi<float>(), Vec3f(1, 0, 0)));
    for (const size_t bent : {size_t(0), size_t(1), size_t(12)})
        for (NamedWriting names : {NamedWriting{"plain", {}}, NamedWriting{"theia", {theia}}, NamedWriting{"numbered", {numbered}}})
            for (const auto& [axes, turned] : {std::pair("y up", Quatf(1, 0, 0, 0)), {"z up", zUp}}) {
                SCOPED_TRACE(formatText("{} keys bent, {}, {}", bent, names.what, axes));
                names.how.alongBones = true, names.how.turned = turned;
                Notes notes;
                const ClipData clip = played(bytesOf(bvhOf(WrittenMotion(rig, walk(rig, bent), names.how))), "bones.bvh");
                EXPECT_LT(farthestApart(clip, plain(bent)), kMadeRestM);
                EXPECT_TRUE(notes.has("its rest pose does not stand; one was made from the frame at")) << notes.text();
            }
}

TEST(MotionInputs, theAnimationOfAGltfIsChosenByNameOrNumberAndTheOthersAreNamed) {
    const auto rig = personOfFile();
    const ClipData right = plain();
    const auto bytes = glbOf(WrittenMotion(rig, walk(rig), {}), {"TPose", "idle", "walk"});
    {
        Notes notes;
        played(bytes, "three.glb");
        EXPECT_TRUE(notes.has("three.glb: the file holds 3 animations: took 'TPose' (0), left 'idle' (1), 'walk' (2)")) << notes.text();
    }
    Notes notes;
    for (const char* choice : {"walk", "2"}) {
        const ClipData clip = played(bytes, "three.glb", {choice});
        EXPECT_EQ(clip.name, "walk");
        EXPECT_LT(farthestApart(clip, right), 2e-3f);
    }
    EXPECT_EQ(notes.text(), "") << "what was chosen needs no word";
    EXPECT_NE(refused(bytes, {"run"}).find("no animation 'run'; the file holds 3: 'TPose' (0), 'idle' (1), 'walk' (2)"), std::string::npos);
    EXPECT_NE(refused(bytes, {"3"}).find("no animation '3'"), std::string::npos);
    EXPECT_NE(refused(bytesOf(bvhOf(WrittenMotion(rig, walk(rig), {}))), {"walk"}).find("a BVH holds one motion"), std::string::npos);
}

/** One key that is no number costs that key: the motion between its neighbours goes on, and the loss is counted and named. */
TEST(MotionInputs, keysOfAGltfThatAreNotSoundAreLeftOutAndNamed) {
    const auto rig = personOfFile();
    const ClipData right = plain();
    const WrittenMotion sound(rig, walk(rig), {});
    const size_t arm = jointOf(rig, "rightHand");
    const auto with = [&](auto change) {
        WrittenMotion motion = sound;
        change(motion);
        return motion;
    };
    const std::string hand = "'" + sound.names[arm] + "'", hips = "'" + sound.names[0] + "'";
    const auto turnOf = [&](float x) { return with([&](WrittenMotion& m) { m.turns[7][arm] = Quatf(x, 0, 0, 0); }); };
    const std::tuple<const char*, WrittenMotion, std::string> table[] = {
        {"a rotation of nan", turnOf(kNan), "1 of 30 in the rotation of " + hand},
        {"a place of infinity", with([](WrittenMotion& m) { m.rootPlaces[3].y = INFINITY; }), "1 of 30 in the translation of " + hips},
        {"a place of 1e30", with([](WrittenMotion& m) { m.rootPlaces[29].x = 1e30f; }), "1 of 30 in the translation of " + hips},
        {"two places", with([](WrittenMotion& m) { m.rootPlaces[0].x = m.rootPlaces[9].z = kNan; }),
         "2 of 30 in the translation of " + hips},
    };
    for (const auto& [what, motion, said] : table) {
        SCOPED_TRACE(what);
        Notes notes;
        EXPECT_LT(farthestApart(played(glbOf(motion, {"walk"}), "bad.glb"), right), 0.03f) << "a key of 1/30 s is bridged";
        EXPECT_TRUE(notes.has(said)) << notes.text();
        EXPECT_TRUE(notes.has("bad.glb: ")) << notes.text();
    }
    for (const float time : {kNan, -1.0f, 4.0f, 1e30f, 8 / 30.0f}) {  // in place of 9/30
        SCOPED_TRACE(time);
        auto bytes = glbOf(sound, {"walk"});
        const float was[2] = {9 / 30.0f, 10 / 30.0f};
        const auto at =
            std::search(bytes.begin(), bytes.end(), reinterpret_cast<const uint8_t*>(was), reinterpret_cast<const uint8_t*>(was + 2));
        ASSERT_NE(at, bytes.end());
        std::memcpy(&*at, &time, sizeof time);
        Notes notes;
        const ClipData clip = played(bytes, "bad.glb");
        EXPECT_LT(farthestApart(clip, right), 0.03f);
        EXPECT_NEAR(clipDurationS(clip), 29 / 30.0, 1e-4);
        EXPECT_TRUE(notes.has("1 of 30 in the rotation of " + hips + ", ")) << notes.text();
        EXPECT_TRUE(notes.has(" more channels")) << notes.text();
    }
    {
        Notes notes;  // of a hand of which no key is sound the rest is told, and the others move
        const ClipData clip = played(glbOf(with([&](WrittenMotion& m) {
                                               for (auto& key : m.turns) key[arm].x = kNan;
                                           }),
                                           {"walk"}),
                                     "bad.glb");
        EXPECT_LT(farthestApart(clip, right), 0.25f);
        EXPECT_TRUE(notes.has("30 of 30 in the rotation of " + hand)) << notes.text();
    }
    const std::string why = refused(glbOf(with([](WrittenMotion& m) {
                                              for (auto& key : m.turns) std::fill(key.begin(), key.end(), Quatf(kNan, 0, 0, 0));
                                              for (Vec3f& place : m.rootPlaces) place.x = kNan;
                                          }),
                                          {"walk"}));
    EXPECT_NE(why.find("animation 'walk' has no sound key"), std::string::npos) << why;
}

/** The map of a file by bone -> node. */
Json mapOf(const WrittenMotion& motion, const char* extension) {
    const bool old = std::string_view(extension) == "VRM";
    Json bones = old ? Json::array() : Json::object();
    for (size_t j = 0; j < motion.rig.size(); ++j) {
        const std::string& bone = motion.rig[j].humanoidBone;
        if (bone.empty()) continue;
        if (old)
            bones.push_back({{"bone", bone}, {"node", j}});
        else
            bones[bone] = {{"node", j}};
    }
    return {{"extensions", {{extension, {{"specVersion", "1.0"}, {"humanoid", {{"humanBones", bones}}}}}}}};
}

TEST(MotionInputs, humanoidMapsOfVrmAreHeard) {
    const auto rig = personOfFile();
    const ClipData right = plain();
    // Names that say the contrary: only the map is right.
    const Writing wrong{[](const std::string& bone) {
        return bone.starts_with("left") ? "right" + bone.substr(4) : bone.starts_with("right") ? "left" + bone.substr(5) : bone;
    }};
    const WrittenMotion motion(rig, walk(rig), wrong);
    for (const char* extension : {"VRM", "VRMC_vrm", "VRMC_vrm_animation"}) {
        SCOPED_TRACE(extension);
        EXPECT_LT(farthestApart(played(glbOf(motion, {"walk"}, mapOf(motion, extension)), "map.glb"), right), 2e-3f);
    }
    EXPECT_GT(farthestApart(played(glbOf(motion, {"walk"}), "nomap.glb"), right), 0.1f) << "without a map the names would have counted";
}

TEST(MotionInputs, humanoidMapsThatContradictThemselvesAreRefused) {
    const auto rig = personOfFile();
    const WrittenMotion motion(rig, walk(rig), {});
    Json twice = mapOf(motion, "VRMC_vrm");
    twice["extensions"]["VRMC_vrm"]["humanoid"]["humanBones"]["chest"]["node"] = 0;
    EXPECT_NE(refused(glbOf(motion, {"walk"}, twice)).find("node 0 ('pelvis') for two bones, 'chest' and 'hips'"), std::string::npos)
        << refused(glbOf(motion, {"walk"}, twice));
    Json beyond = mapOf(motion, "VRMC_vrm_animation");
    beyond["extensions"]["VRMC_vrm_animation"]["humanoid"]["humanBones"]["hips"]["node"] = 999;
    EXPECT_NE(refused(glbOf(motion, {"walk"}, beyond)).find("names node 999 as 'hips'; there are"), std::string::npos);
}

TEST(MotionInputs, anotherKindOfFileIsNamedWithTheRemedy) {
    const std::string utf16("\xFF\xFEH\0I\0E\0R\0", 10), bare16("H\0I\0E\0R\0", 8);
    const std::pair<std::string, const char*> kinds[] = {
        {std::string("Kaydara FBX Binary  \0\x1a\0", 23), "an FBX file; open it in Blender"},
        {"; FBX 7.4.0 project file\n", "an FBX file in ASCII"},
        {"{ \"asset\": {\"version\": \"2.0\"}, \"buffers\": [{\"uri\": \"walk.bin\"}] }", "export it as one binary file (.glb)"},
        {std::string("\0\0\0\x20"
                     "ftypisom",
                     12),
         "a video"},
        {std::string("\x1A\x45\xDF\xA3", 4), "a video"},
        {utf16, "text in UTF-16; save it as UTF-8"},
        {bare16, "text in UTF-16"},
        {std::string("\0H\0I\0E\0R", 8), "text in UTF-16"},
        {std::string("PK\x03\x04", 4), "packed"},
        {"", "an empty file"},
        {"<?xml version=\"1.0\"?><COLLADA>", "COLLADA"},
        {":ASF-SKELETON\n", "Acclaim"},
        {"ply\nformat ascii 1.0\n", "general splats"},
        {"# a walk\n0.1 0.2\n", "begins with '#' instead of HIERARCHY"},
    };
    for (const auto& [text, says] : kinds) {
        const std::string message = refused(bytesOf(text));
        EXPECT_NE(message.find(says), std::string::npos) << message;
        EXPECT_EQ(message.find("begins with the word HIERARCHY"), std::string::npos);
        EXPECT_NE(message.find("a file"), std::string::npos) << "the file is named: " << message;
    }
}

TEST(MotionInputs, anAnimationWithoutASkeletonSaysSo) {
    auto box = personOfFile();
    box.resize(1);
    const WrittenMotion motion(box, {Pose::rest(1), Pose::rest(1)}, {[](const std::string&) { return std::string("Cube"); }});
    const std::string message = refused(glbOf(motion, {"spin"}));
    EXPECT_NE(message.find("the motion's skeleton has no recognisable hips with arms or legs; its joints are: Cube"), std::string::npos)
        << message;
}

// ---- inputs of ../shared/data/faults, each with the same motion in a plain file

std::optional<std::vector<uint8_t>> fault(const std::string& name) {
    const auto shared = sharedData("faults");
    if (!shared) return std::nullopt;
    std::ifstream in(*shared / name, std::ios::binary);
    if (!in) return std::nullopt;
    return std::vector<uint8_t>((std::istreambuf_iterator<char>(in)), {});
}

#define NEED_FAULT(bytes, name)     \
    const auto bytes = fault(name); \
    if (!bytes) GTEST_SKIP() << "shared/data/faults/" << name << " is not at hand (set DOPPEL_SHARED_DATA)"

TEST(MotionFaults, namesOfOtherProgramsGiveTheSameMotion) {
    NEED_FAULT(right, "names-mixamo.bvh");
    const ClipData twin = played(*right, "names-mixamo.bvh");
    for (const char* name : {"names-soma.bvh", "names-theia.bvh"}) {
        NEED_FAULT(bytes, name);
        EXPECT_LT(farthestApart(played(*bytes, name), twin), 1e-4f) << name;
    }
    NEED_FAULT(vrma, "anim.vrma");
    NEED_FAULT(two, "two.glb");
    EXPECT_LT(farthestApart(played(*vrma, "anim.vrma"), played(*two, "two.glb", {"walk"})), 1e-4f);
    EXPECT_LT(farthestApart(played(*two, "two.glb", {"walk"}), twin), 5e-3f);
}

TEST(MotionFaults, aBentStartGivesWhatTheTwinGives) {
    NEED_FAULT(right, "bent-first.bvh");
    NEED_FAULT(bytes, "lafan-bent-first.bvh");
    EXPECT_LT(farthestApart(played(*bytes, "lafan"), played(*right, "bent")), 0.07f)
        << "metres, measured 0.058 at the head: its trunk leans at rest, which a made rest pose cannot tell";
}

TEST(MotionFaults, moreAndNospaceAreRead) {
    NEED_FAULT(more, "more.bvh");
    NEED_FAULT(close, "nospace.bvh");
    Notes notes;
    const ClipData a = played(*more, "more.bvh");
    EXPECT_TRUE(notes.has("were left out")) << notes.text();
    const ClipData b = played(*close, "nospace.bvh");
    EXPECT_EQ(b.timesS.size(), 20u);
    EXPECT_LT(farthestApart(a, b), 1e-4f);
}

}  // namespace
}  // namespace dpl
