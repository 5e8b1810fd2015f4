// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/humanoid.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>

#include "sdk/avatar/limbs_by_shape.h"

namespace dpl {
namespace {

constexpr std::array<std::string_view, 55> kBones = {"hips",
                                                     "spine",
                                                     "chest",
                                                     "upperChest",
                                                     "neck",
                                                     "head",
                                                     "leftEye",
                                                     "rightEye",
                                                     "jaw",
                                                     "leftUpperLeg",
                                                     "leftLowerLeg",
                                                     "leftFoot",
                                                     "leftToes",
                                                     "rightUpperLeg",
                                                     "rightLowerLeg",
                                                     "rightFoot",
                                                     "rightToes",
                                                     "leftShoulder",
                                                     "leftUpperArm",
                                                     "leftLowerArm",
                                                     "leftHand",
                                                     "rightShoulder",
                                                     "rightUpperArm",
                                                     "rightLowerArm",
                                                     "rightHand",
                                                     "leftThumbMetacarpal",
                                                     "leftThumbProximal",
                                                     "leftThumbDistal",
                                                     "leftIndexProximal",
                                                     "leftIndexIntermediate",
                                                     "leftIndexDistal",
                                                     "leftMiddleProximal",
                                                     "leftMiddleIntermediate",
                                                     "leftMiddleDistal",
                                                     "leftRingProximal",
                                                     "leftRingIntermediate",
                                                     "leftRingDistal",
                                                     "leftLittleProximal",
                                                     "leftLittleIntermediate",
                                                     "leftLittleDistal",
                                                     "rightThumbMetacarpal",
                                                     "rightThumbProximal",
                                                     "rightThumbDistal",
                                                     "rightIndexProximal",
                                                     "rightIndexIntermediate",
                                                     "rightIndexDistal",
                                                     "rightMiddleProximal",
                                                     "rightMiddleIntermediate",
                                                     "rightMiddleDistal",
                                                     "rightRingProximal",
                                                     "rightRingIntermediate",
                                                     "rightRingDistal",
                                                     "rightLittleProximal",
                                                     "rightLittleIntermediate",
                                                     "rightLittleDistal"};

struct Alias {
    std::string_view base, bone;
};

// Names of bones that exist on both sides. "left" or "right" is put in front of the bone.
constexpr Alias kSided[] = {
    {"clavicle", "Shoulder"}, {"collar", "Shoulder"},    {"collarbone", "Shoulder"}, {"clav", "Shoulder"},     {"shoulder", "Shoulder"},
    {"upperarm", "UpperArm"}, {"uparm", "UpperArm"},     {"arm", "UpperArm"},        {"shldr", "UpperArm"},    {"shldrbend", "UpperArm"},
    {"bicep", "UpperArm"},    {"lowerarm", "LowerArm"},  {"loarm", "LowerArm"},      {"forearm", "LowerArm"},  {"forearmbend", "LowerArm"},
    {"elbow", "LowerArm"},    {"hand", "Hand"},          {"wrist", "Hand"},          {"upperleg", "UpperLeg"}, {"upleg", "UpperLeg"},
    {"thigh", "UpperLeg"},    {"thighbend", "UpperLeg"}, {"hip", "UpperLeg"},        {"lowerleg", "LowerLeg"}, {"loleg", "LowerLeg"},
    {"leg", "LowerLeg"},      {"shin", "LowerLeg"},      {"calf", "LowerLeg"},       {"knee", "LowerLeg"},     {"foot", "Foot"},
    {"ankle", "Foot"},        {"toe", "Toes"},           {"toes", "Toes"},           {"toebase", "Toes"},      {"ball", "Toes"},
    {"eye", "Eye"},           {"eyesmplhf", "Eye"},
};
constexpr Alias kMiddle[] = {
    {"hips", "hips"},
    {"hip", "hips"},
    {"pelvis", "hips"},
    {"spine", "spine"},
    {"lowerback", "spine"},
    {"abdomen", "spine"},
    {"abdomenlower", "spine"},
    {"abdomenupper", "chest"},
    {"chestlower", "chest"},
    {"chest", "chest"},
    {"upperchest", "upperChest"},
    {"chestupper", "upperChest"},
    {"neck", "neck"},
    {"necklower", "neck"},
    {"head", "head"},
    {"jaw", "jaw"},
    {"lowerjaw", "jaw"},
};
constexpr Alias kFingers[] = {
    {"thumb", "Thumb"}, {"index", "Index"},   {"middle", "Middle"}, {"mid", "Middle"},
    {"ring", "Ring"},   {"little", "Little"}, {"pinky", "Little"},  {"pinkie", "Little"},
};

template <size_t N>
std::string_view lookUp(const Alias (&table)[N], std::string_view base) {
    for (const Alias& alias : table)
        if (alias.base == base) return alias.bone;
    return {};
}

/** Parts of a joint name: "mixamorig:LeftHandIndex2" is {left, "handindex", {"2"}}. */
struct NameParts {
    int side = 0;                      // +1 left, -1 right
    std::string base;                  // lower-case words without side and numbers
    std::vector<std::string> numbers;  // as written: "01" and "1" differ
    bool snakeSide = false;            // the side is a lower-case word in front: "left_shoulder"
    bool capital = false;              // the first word starts with a capital
    bool separatedNumber = false;      // a separator stands before the first number
};

std::string_view stripPrefix(std::string_view name) {
    if (const size_t colon = name.find_last_of(":|"); colon != std::string_view::npos) name.remove_prefix(colon + 1);
    for (std::string_view prefix :
         {"mixamorig_", "mixamorig", "DEF-", "ORG-", "J_Bip_C_", "J_Bip_", "Bip001 ", "Bip01 ", "Bip001_", "Bip01_", "CC_Base_"})
        if (name.size() > prefix.size() && name.substr(0, prefix.size()) == prefix) return name.substr(prefix.size());
    return name;
}

NameParts takeApart(std::string_view name) {
    NameParts parts;
    std::vector<std::string> words;
    std::string word;
    bool separator = false;
    const auto flush = [&] {
        if (!word.empty()) words.push_back(word);
        word.clear();
    };
    for (size_t i = 0; i < name.size(); ++i) {
        const unsigned char c = static_cast<unsigned char>(name[i]);
        if (!std::isalnum(c)) {
            flush();
            separator = true;
            continue;
        }
        const unsigned char before = i > 0 ? static_cast<unsigned char>(name[i - 1]) : 0;
        const unsigned char after = i + 1 < name.size() ? static_cast<unsigned char>(name[i + 1]) : 0;
        const bool camel = std::isupper(c) && (std::islower(before) || (std::isupper(before) && std::islower(after)));
        if (camel || (std::isdigit(c) != 0) != (std::isdigit(before) != 0)) flush();
        if (std::isdigit(c) && word.empty() && parts.numbers.empty()) parts.separatedNumber = separator;
        if (words.empty() && word.empty()) parts.capital = std::isupper(c) != 0;
        word += char(std::tolower(c));
        separator = false;
        if (std::isdigit(c) && !std::isdigit(after)) {
            parts.numbers.push_back(word);
            word.clear();
        }
    }
    flush();
    for (size_t i = 0; i < words.size(); ++i) {
        const std::string& w = words[i];
        const int side = w == "left" || w == "l" || w == "lft" ? 1 : (w == "right" || w == "r" || w == "rgt" ? -1 : 0);
        if (side != 0 && parts.side == 0) {
            parts.side = side;
            parts.snakeSide = i == 0 && w.size() > 1 && !parts.capital && name.find('_') != std::string_view::npos;
        } else {
            parts.base += w;
        }
    }
    return parts;
}

std::string sided(int side, std::string_view bone) {
    return std::string(side > 0 ? "left" : "right").append(bone);
}

int sideOf(std::string_view jointName) {
    NameParts parts = takeApart(stripPrefix(jointName));
    if (parts.side != 0) return parts.side;
    if (jointName.find("\u5de6") != std::string_view::npos) return 1;  // Japanese, as in MikuMikuDance
    if (jointName.find("\u53f3") != std::string_view::npos) return -1;
    // "lfarm", "rThigh1": a letter before a word. Where the words are not sides, both sides of the body get the same one.
    return parts.base.size() > 2 ? (parts.base[0] == 'l' ? 1 : parts.base[0] == 'r' ? -1 : 0) : 0;
}

/** Bone name of a finger and its segment 1 to 3. The thumb's segments have names of their own. */
std::string fingerBone(int side, std::string_view finger, int segment) {
    static constexpr std::string_view kSegments[] = {"Proximal", "Intermediate", "Distal"};
    static constexpr std::string_view kThumbSegments[] = {"Metacarpal", "Proximal", "Distal"};
    if (segment < 1 || segment > 3) return {};
    return sided(side, finger).append(finger == "Thumb" ? kThumbSegments[segment - 1] : kSegments[segment - 1]);
}

int small(const std::string& digits) {
    return digits.size() > 3 ? -1 : std::stoi(digits);
}

std::string fingerFor(const NameParts& parts) {
    std::string_view base = parts.base;
    if (base == "finger" && parts.numbers.size() == 2) {  // MakeHuman: finger1-1 is the thumb's first segment
        const int finger = small(parts.numbers[0]);
        static constexpr std::string_view kByNumber[] = {"Thumb", "Index", "Middle", "Ring", "Little"};
        return finger >= 1 && finger <= 5 ? fingerBone(parts.side, kByNumber[finger - 1], small(parts.numbers[1])) : std::string();
    }
    if (base.starts_with("hand")) base.remove_prefix(4);
    if (base.starts_with("f") && !lookUp(kFingers, base.substr(1)).empty()) base.remove_prefix(1);  // Rigify: f_index.01.L
    if (parts.numbers.size() == 1) {
        const std::string_view finger = lookUp(kFingers, base);
        return finger.empty() ? std::string() : fingerBone(parts.side, finger, small(parts.numbers[0]));
    }
    if (!parts.numbers.empty()) return {};
    static constexpr Alias kSpelled[] = {{"metacarpal", "1"}, {"proximal", "1"}, {"intermediate", "2"}, {"distal", "3"}};
    for (const Alias& alias : kFingers) {
        if (!base.starts_with(alias.base)) continue;
        const std::string_view rest = base.substr(alias.base.size());
        if (alias.bone == "Thumb") {
            if (rest == "metacarpal") return fingerBone(parts.side, "Thumb", 1);
            if (rest == "proximal" || rest == "intermediate") return fingerBone(parts.side, "Thumb", 2);
            if (rest == "distal") return fingerBone(parts.side, "Thumb", 3);
        } else if (const std::string_view segment = rest == "metacarpal" ? std::string_view() : lookUp(kSpelled, rest); !segment.empty()) {
            return fingerBone(parts.side, alias.bone, segment[0] - '0');
        }
    }
    return {};
}

std::string spineFor(const NameParts& parts) {
    static constexpr std::string_view kUp[] = {"spine", "chest", "upperChest"};
    const std::string& digits = parts.numbers[0];
    const int number = small(digits);
    if (digits.size() == 2 && !parts.separatedNumber)  // MakeHuman numbers five vertebrae from the neck down
        return number == 5 ? "spine" : number == 3 ? "chest" : number == 1 ? "upperChest" : "";
    if (digits.size() == 1 && parts.capital && !parts.separatedNumber)  // Mixamo: Spine, Spine1, Spine2
        return number == 1 ? "chest" : number == 2 ? "upperChest" : "";
    return number >= 1 && number <= 3 ? std::string(kUp[number - 1]) : std::string();
}

}  // namespace

std::span<const std::string_view> humanoidBoneNames() {
    return kBones;
}

std::string humanoidBoneFor(std::string_view jointName) {
    const std::string_view name = stripPrefix(jointName);
    if (name.empty() || name.starts_with("__")) return {};  // helper joints in MakeHuman's BVH files
    NameParts parts = takeApart(name);
    if (parts.side == 0 && parts.base.size() > 2 && lookUp(kMiddle, parts.base).empty() && lookUp(kSided, parts.base).empty() &&
        (parts.base[0] == 'l' || parts.base[0] == 'r') && !lookUp(kSided, std::string_view(parts.base).substr(1)).empty()) {
        parts.side = parts.base[0] == 'l' ? 1 : -1;  // "lhand"
        parts.base.erase(0, 1);
    }
    const std::vector<std::string>& n = parts.numbers;
    if (parts.side == 0) {
        if (parts.base == "spine" && n.size() == 1) return spineFor(parts);
        if (parts.base == "chest" && n.size() == 1) return n[0] == "2" ? "upperChest" : n[0] == "1" || n[0] == "01" ? "chest" : "";
        if (parts.base == "neck" && n.size() == 1) return small(n[0]) == 1 ? "neck" : "";
        return n.empty() ? std::string(lookUp(kMiddle, parts.base)) : std::string();
    }
    if (std::string finger = fingerFor(parts); !finger.empty()) return finger;
    if (!n.empty() && !(n.size() == 1 && n[0] == "01")) return {};  // second half of a bone ("upperarm02.L"), single toes ("toe2-1.L")
    if (parts.base == "shoulder") {
        if (!n.empty()) return {};                                  // MakeHuman's shoulder01 lies below its clavicle, which is the shoulder
        if (parts.snakeSide) return sided(parts.side, "UpperArm");  // SMPL calls them left_collar, left_shoulder, left_elbow
    }
    const std::string_view bone = lookUp(kSided, parts.base);
    return bone.empty() ? std::string() : sided(parts.side, bone);
}

namespace {

/** Decides by the place in the tree what names leave ambiguous; see humanoidBones(). */
class TreeResolver {
public:
    explicit TreeResolver(std::span<const JointData> joints) : joints_(joints), bones_(joints.size()) {
        for (size_t j = 0; j < joints.size(); ++j) bones_[j] = humanoidBoneFor(joints[j].name);
    }

    /** at: positions of the joints where the person stands. */
    std::vector<std::string> run(std::span<const Vec3f> at) {
        const std::vector<std::string> named = bones_;
        byNames();
        if (isWhole()) return std::move(bones_);
        std::vector<int> sides;
        for (const JointData& joint : joints_) sides.push_back(sideOf(joint.name));
        if (auto limbs = limbsByShape(joints_, at, sides)) {
            bones_ = std::move(*limbs);
            keepSmallBones(named);
            settleTorso();
        }
        return std::move(bones_);
    }

private:
    void byNames() {
        for (const char* side : {"left", "right"}) {
            const std::string s = side;
            settleSecond(s + "Shoulder", s + "UpperArm");
            settleSecond(s + "Foot", s + "Toes");
            if (!find(s + "UpperArm"))
                if (auto shoulder = find(s + "Shoulder")) bones_[*shoulder] = s + "UpperArm";
        }
        keepFirstOfEach();
        settleTorso();
    }
    /** Whether hips, head and four limbs are there, each bone of a limb below the one before. */
    bool isWhole() const {
        if (!find("hips") || !find("head")) return false;
        for (const std::string side : {"left", "right"})
            for (const auto& limb : {std::array{"UpperLeg", "LowerLeg", "Foot"}, std::array{"UpperArm", "LowerArm", "Hand"}}) {
                const auto upper = find(side + limb[0]), lower = find(side + limb[1]), end = find(side + limb[2]);
                if (!upper || !lower || !end || !isAbove(*upper, *lower) || !isAbove(*lower, *end)) return false;
            }
        return true;
    }
    /** Fingers, eyes and jaw that their names tell, where they hang from the hand or head of their side. */
    void keepSmallBones(const std::vector<std::string>& named) {
        for (size_t j = 0; j < named.size(); ++j) {
            const std::string_view bone = named[j];
            if (bone.empty() || !bones_[j].empty() || find(bone)) continue;
            const std::string side = bone.starts_with("left") ? "left" : bone.starts_with("right") ? "right" : "";
            const bool ofHead = bone == "jaw" || bone.ends_with("Eye");
            const bool finger = std::any_of(std::begin(kFingers), std::end(kFingers),
                                            [&](const Alias& f) { return bone.substr(side.size()).starts_with(f.bone); });
            const auto carrier = ofHead ? find("head") : finger ? find(side + "Hand") : std::nullopt;
            if (carrier && isAbove(*carrier, j)) bones_[j] = bone;
        }
    }
    std::optional<size_t> find(std::string_view bone) const {
        const auto at = std::find(bones_.begin(), bones_.end(), bone);
        if (at == bones_.end()) return std::nullopt;
        return size_t(at - bones_.begin());
    }
    bool isAbove(size_t ancestor, size_t joint) const {
        for (int32_t j = joints_[joint].parent; j >= 0; j = joints_[size_t(j)].parent)
            if (size_t(j) == ancestor) return true;
        return false;
    }
    std::optional<size_t> common(std::optional<size_t> a, std::optional<size_t> b) const {
        if (!a || !b) return std::nullopt;
        for (int32_t j = int32_t(*a); j >= 0; j = joints_[size_t(j)].parent)
            if (size_t(j) == *b || isAbove(size_t(j), *b)) return size_t(j);
        return std::nullopt;
    }
    /** If a second joint named `bone` lies below the first and no joint is `next`, the second becomes `next`. */
    void settleSecond(const std::string& bone, const std::string& next) {
        const auto first = find(bone);
        if (!first || find(next)) return;
        for (size_t j = *first + 1; j < bones_.size(); ++j)
            if (bones_[j] == bone && isAbove(*first, j)) {
                bones_[j] = next;
                return;
            }
    }
    void keepFirstOfEach() {
        for (size_t j = 0; j < bones_.size(); ++j)
            if (!bones_[j].empty() && *find(bones_[j]) != j) bones_[j].clear();
    }
    void relabel(std::string_view bone, std::optional<size_t> joint) {
        if (auto old = find(bone)) bones_[*old].clear();
        if (joint) bones_[*joint] = bone;
    }
    void settleTorso() {
        const auto legs = common(find("leftUpperLeg"), find("rightUpperLeg"));
        const auto head = find("head");
        const auto arms = common(find("leftUpperArm"), find("rightUpperArm"));
        const auto hips = common(legs, head ? head : arms);
        if (!hips) return;  // no legs, or nothing above them: keep what the names say
        relabel("hips", hips);
        const auto top = head ? common(arms, head) : arms;
        if (!top || *top == *hips || !isAbove(*hips, *top)) return;
        if (top == head) return;    // arms below the head: chest and neck cannot be told apart; keep what the names say
        std::vector<size_t> chain;  // from the joint above the hips up to the joint where the arms branch off
        for (size_t j = *top; j != *hips; j = size_t(joints_[j].parent)) chain.insert(chain.begin(), j);
        for (std::string_view bone : {"spine", "chest", "upperChest"}) relabel(bone, std::nullopt);
        bones_[chain.front()] = "spine";
        if (chain.size() == 2) bones_[chain[1]] = "chest";
        if (chain.size() >= 3) {
            bones_[chain[chain.size() / 2]] = "chest";
            bones_[chain.back()] = "upperChest";
        }
        if (!head) return;
        std::optional<size_t> neck;
        for (size_t j = size_t(joints_[*head].parent); j != *top; j = size_t(joints_[j].parent)) neck = j;
        relabel("neck", neck);
    }

    std::span<const JointData> joints_;
    std::vector<std::string> bones_;
};

}  // namespace

std::vector<std::string> humanoidBones(std::span<const JointData> joints, std::span<const Vec3f> standing) {
    if (std::any_of(joints.begin(), joints.end(), [](const JointData& j) { return !j.humanoidBone.empty(); })) {
        std::vector<std::string> bones;
        for (const JointData& joint : joints) bones.push_back(joint.humanoidBone);
        return bones;
    }
    std::vector<Vec3f> rest;
    for (const JointData& joint : joints) rest.push_back(joint.restPosition);
    return TreeResolver(joints).run(standing.empty() ? rest : standing);
}

void assignHumanoidBones(std::vector<JointData>& joints) {
    const std::vector<std::string> bones = humanoidBones(joints);
    for (size_t j = 0; j < joints.size(); ++j) joints[j].humanoidBone = bones[j];
}

BoneMap bonesOf(std::span<const JointData> joints, std::span<const Vec3f> standing) {
    BoneMap map;
    const std::vector<std::string> bones = humanoidBones(joints, standing);
    for (size_t j = 0; j < bones.size(); ++j)
        if (!bones[j].empty()) map.emplace(bones[j], j);
    return map;
}

std::optional<size_t> findBone(const BoneMap& bones, std::string_view bone) {
    const auto at = bones.find(bone);
    return at == bones.end() ? std::nullopt : std::optional(at->second);
}

std::optional<size_t> topOfSpine(const BoneMap& bones) {
    for (std::string_view bone : {"upperChest", "chest", "spine"})
        if (auto joint = findBone(bones, bone)) return joint;
    return std::nullopt;
}

}  // namespace dpl
