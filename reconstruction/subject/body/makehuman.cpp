// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/makehuman.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "reconstruction/subject/body/body_tools.h"
#include "reconstruction/subject/body/makehuman_files.h"
#include "sdk/avatar/humanoid.h"
#include "sdk/format/skin_weights.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

constexpr float kMetresPerDm = 0.1f;
constexpr uint32_t kHm08BodyVertices = 13380;  // vertices [0, 13380) of hm08 are skin; the rest are helpers and joint cubes
constexpr glm::u8vec4 kSkinColour(214, 172, 146, 255);

/** Part of a morph: `weight`·(positive − negative)/2. The two targets are the ends of a MakeHuman slider. */
struct TargetPair {
    const char* positive;
    const char* negative;
    float weight = 1;
};

struct MorphRecipe {
    const char* name;
    float scale;  // slider position at value 1; ±1 is about one standard deviation of adults
    float minValue, maxValue;
    std::vector<TargetPair> pairs;
};

#define MH_MACRO(gender) "macrodetails/universal-" gender "-young-"
#define MH_HEIGHT(gender) "macrodetails/height/" gender "-young-averagemuscle-averageweight-"
#define MH_PROPORTIONS(gender) "macrodetails/proportions/" gender "-young-averagemuscle-averageweight-"

/** The same parts for the left and the right side. */
std::vector<TargetPair> bothSides(const char* lPlus, const char* lMinus, const char* rPlus, const char* rMinus) {
    return {{lPlus, lMinus}, {rPlus, rMinus}};
}

std::vector<TargetPair> join(std::initializer_list<std::vector<TargetPair>> parts) {
    std::vector<TargetPair> all;
    for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
}

#define MH_LR(folder, what) \
    bothSides(folder "/l-" what "-incr", folder "/l-" what "-decr", folder "/r-" what "-incr", folder "/r-" what "-decr")
#define MH_ONE(what)                   \
    std::vector<TargetPair> {          \
        { what "-incr", what "-decr" } \
    }

std::vector<MorphRecipe> recipes() {
    return {
        // Macro targets, averaged over the sexes. The height slider spans −37 to +72 cm, so 0.15 is about 8 cm.
        {"height",
         0.15f,
         -4,
         4,
         {{MH_HEIGHT("female") "maxheight", MH_HEIGHT("female") "minheight", 0.5f},
          {MH_HEIGHT("male") "maxheight", MH_HEIGHT("male") "minheight", 0.5f}}},
        {"weight",
         0.6f,
         -2.5f,
         3,
         {{MH_MACRO("female") "averagemuscle-maxweight", MH_MACRO("female") "averagemuscle-minweight", 0.5f},
          {MH_MACRO("male") "averagemuscle-maxweight", MH_MACRO("male") "averagemuscle-minweight", 0.5f}}},
        {"build",
         0.6f,
         -2.5f,
         2.5f,
         {{MH_MACRO("female") "maxmuscle-averageweight", MH_MACRO("female") "minmuscle-averageweight", 0.5f},
          {MH_MACRO("male") "maxmuscle-averageweight", MH_MACRO("male") "minmuscle-averageweight", 0.5f}}},
        {"gender",
         1,
         -1.5f,
         1.5f,
         {{MH_MACRO("male") "averagemuscle-averageweight", MH_MACRO("female") "averagemuscle-averageweight"},
          {"macrodetails/caucasian-male-young", "macrodetails/caucasian-female-young", 1.0f / 3},
          {"macrodetails/asian-male-young", "macrodetails/asian-female-young", 1.0f / 3},
          {"macrodetails/african-male-young", "macrodetails/african-female-young", 1.0f / 3}}},
        {"age",
         0.5f,
         -0.5f,
         2,
         {{"macrodetails/caucasian-female-old", "macrodetails/caucasian-female-young", 0.5f},
          {"macrodetails/caucasian-male-old", "macrodetails/caucasian-male-young", 0.5f}}},
        {"proportions",
         0.7f,
         -2,
         2,
         {{MH_PROPORTIONS("female") "idealproportions", MH_PROPORTIONS("female") "uncommonproportions", 0.5f},
          {MH_PROPORTIONS("male") "idealproportions", MH_PROPORTIONS("male") "uncommonproportions", 0.5f}}},
        // Details.
        {"torso_length", 0.5f, -3, 3, MH_ONE("torso/torso-scale-vert")},
        {"torso_width", 0.4f, -3, 3, MH_ONE("torso/torso-scale-horiz")},
        {"torso_depth", 0.4f, -3, 3, MH_ONE("torso/torso-scale-depth")},
        {"shoulder_width", 0.4f, -3, 3, MH_ONE("torso/measure-shoulder-dist")},
        {"hip_width", 0.4f, -3, 3, MH_ONE("hip/hip-scale-horiz")},
        {"belly", 0.4f, -2, 3, MH_ONE("torso/measure-waist-circ")},
        {"upper_leg_length", 0.3f, -3, 3, MH_ONE("legs/upperlegs-height")},
        {"lower_leg_length", 0.3f, -3, 3, MH_ONE("legs/lowerlegs-height")},
        {"upper_arm_length", 0.4f, -3, 3, MH_ONE("arms/measure-upperarm-length")},
        {"lower_arm_length", 0.4f, -3, 3, MH_ONE("arms/measure-lowerarm-length")},
        {"leg_thickness", 0.4f, -3, 3, join({MH_LR("legs", "upperleg-fat"), MH_LR("legs", "lowerleg-fat")})},
        {"arm_thickness", 0.4f, -3, 3, join({MH_LR("arms", "upperarm-fat"), MH_LR("arms", "lowerarm-fat")})},
        {"neck_length", 0.4f, -3, 3, MH_ONE("neck/measure-neck-height")},
        {"head_size", 0.3f, -3, 3,
         join({MH_ONE("head/head-scale-horiz"), MH_ONE("head/head-scale-vert"), MH_ONE("head/head-scale-depth")})},
        {"head_forward", 0.3f, -3, 3, {{"head/head-trans-forward", "head/head-trans-backward"}}},
        {"hand_size", 0.3f, -3, 3, MH_LR("hands", "hand-scale")},
        {"foot_size", 0.3f, -3, 3, MH_LR("feet", "foot-scale")},
    };
}

/** Targets that turn base.obj into the neutral adult. */
const std::array<TargetPair, 8> kNeutral = {{
    {MH_MACRO("female") "averagemuscle-averageweight", nullptr, 0.5f},
    {MH_MACRO("male") "averagemuscle-averageweight", nullptr, 0.5f},
    {"macrodetails/caucasian-female-young", nullptr, 1.0f / 6},
    {"macrodetails/caucasian-male-young", nullptr, 1.0f / 6},
    {"macrodetails/asian-female-young", nullptr, 1.0f / 6},
    {"macrodetails/asian-male-young", nullptr, 1.0f / 6},
    {"macrodetails/african-female-young", nullptr, 1.0f / 6},
    {"macrodetails/african-male-young", nullptr, 1.0f / 6},
}};

Status addTarget(const fs::path& root, const char* name, float factor, std::vector<Vec3f>& offsetsM) {
    fs::path path = root / "targets" / (std::string(name) + ".target.gz");
    if (!fs::exists(path)) path.replace_extension();  // .target.gz -> .target
    DPL_TRY(const auto rows, readMakeHumanTarget(path, offsetsM.size()));
    for (const TargetRow& row : rows) offsetsM[row.vertex] += factor * kMetresPerDm * row.offsetDm;
    return {};
}

Vec3f meanOf(std::span<const Vec3f> values, std::span<const uint32_t> vertices) {
    Vec3d sum(0);
    for (uint32_t v : vertices) sum += Vec3d(values[v]);
    return Vec3f(sum / double(vertices.size()));
}

/** The lowest hundredth of the skin's vertices: the soles of both feet. */
std::vector<uint32_t> soleVertices(std::span<const Vec3f> positions) {
    std::vector<uint32_t> order(kHm08BodyVertices);
    for (uint32_t v = 0; v < order.size(); ++v) order[v] = v;
    std::sort(order.begin(), order.end(),
              [&](uint32_t a, uint32_t b) { return std::pair(positions[a].y, a) < std::pair(positions[b].y, b); });
    order.resize(order.size() / 100);
    return order;
}

void addKeypoints(const MakeHumanMesh& source, std::span<const Vec3f> positions, BodyModel& body) {
    body.keypoints = deriveKeypoints(body);
    // hm08 vertices: tip of the nose, tragus of each ear, crown. The pupils are dropped helper vertices, so they are anchored to the lids.
    const std::pair<const char*, uint32_t> vertices[] = {{"nose", 297}, {"ear_l", 12038}, {"ear_r", 5439}, {"head_top", 881}};
    for (const auto& [name, vertex] : vertices)
        for (BodyKeypoint& k : body.keypoints)
            if (k.name == name) k = {name, {{vertex, 1.0f}}, {}};
    std::vector<uint32_t> skin(kHm08BodyVertices);
    for (uint32_t v = 0; v < skin.size(); ++v) skin[v] = v;
    const std::pair<const char*, const char*> eyes[] = {{"eye_l", "helper-l-eye"}, {"eye_r", "helper-r-eye"}};
    for (const auto& [name, group] : eyes) {
        const auto eye = source.groups.find(group);
        if (eye == source.groups.end() || eye->second.empty()) continue;
        const uint32_t pupil = *std::max_element(eye->second.begin(), eye->second.end(),
                                                 [&](uint32_t a, uint32_t b) { return positions[a].z < positions[b].z; });
        std::erase_if(body.keypoints, [&, name = name](const BodyKeypoint& k) { return k.name == name; });
        body.keypoints.push_back({name, anchorPoint(body.mesh, skin, positions[pupil]), {}});
    }
}

Status addSkin(const MakeHumanRig& rig, const std::vector<uint32_t>& jointOfBone, BodyModel& body) {
    std::vector<std::vector<std::pair<uint32_t, float>>> influences(kHm08BodyVertices);
    for (size_t b = 0; b < rig.bones.size(); ++b)
        if (const auto weights = rig.weights.find(rig.bones[b].name); weights != rig.weights.end())
            for (const auto& [vertex, weight] : weights->second)
                if (vertex < kHm08BodyVertices && weight > 0) influences[vertex].emplace_back(jointOfBone[b], weight);
    body.mesh.jointIndices.resize(kHm08BodyVertices);
    body.mesh.jointWeights.resize(kHm08BodyVertices);
    for (uint32_t v = 0; v < kHm08BodyVertices; ++v) {
        if (influences[v].empty()) return fail(Code::CorruptData, "the rig gives vertex {} of the skin no weight", v);
        const PackedWeights packed = packWeights(influences[v]);
        body.mesh.jointIndices[v] = packed.joints;
        body.mesh.jointWeights[v] = packed.weights;
    }
    return {};
}

}  // namespace

Result<BodyModel> importMakeHuman(const fs::path& folder, const MakeHumanOptions& options) {
    fs::path root = folder;
    if (!fs::exists(root / "3dobjs" / "base.obj")) root = folder / "mpfb2";
    if (!fs::exists(root / "3dobjs" / "base.obj"))
        return fail(Code::NotFound, "{}: no 3dobjs/base.obj here or in mpfb2/; give the MakeHuman / MPFB2 data folder", folder.string());
    const fs::path rigs = root / "rigs" / "standard";
    const fs::path rigPath = rigs / ("rig." + options.rig + ".json"), weightsPath = rigs / ("weights." + options.rig + ".json");
    if (!fs::exists(rigPath) || !fs::exists(weightsPath))
        return fail(Code::NotFound, "{}: rig '{}' needs both rig.{}.json and weights.{}.json there", rigs.string(), options.rig,
                    options.rig, options.rig);

    DPL_TRY(const MakeHumanMesh source, readMakeHumanObj(root / "3dobjs" / "base.obj"));
    const size_t sourceCount = source.positionsDm.size();
    if (sourceCount < kHm08BodyVertices)
        return fail(Code::Unsupported, "{}: {} vertices; the hm08 base mesh has 19,158", root.string(), sourceCount);
    DPL_TRY(const MakeHumanRig rig, readMakeHumanRig(rigPath, weightsPath, source));

    std::vector<Vec3f> positions(sourceCount);
    for (size_t v = 0; v < sourceCount; ++v) positions[v] = kMetresPerDm * source.positionsDm[v];
    for (const TargetPair& t : kNeutral) DPL_RETURN_IF_ERROR(addTarget(root, t.positive, t.weight, positions));
    const std::vector<uint32_t> soles = soleVertices(positions);
    const float ground = meanOf(positions, soles).y;
    for (Vec3f& p : positions) p.y -= ground;

    BodyModel body;
    body.name = "makehuman-" + options.rig;
    body.mesh.restPositions.assign(positions.begin(), positions.begin() + kHm08BodyVertices);
    body.mesh.colours.assign(kHm08BodyVertices, kSkinColour);
    for (const auto& f : source.bodyFaces) {
        if (*std::max_element(f.begin(), f.end()) >= kHm08BodyVertices) continue;
        const auto diagonal2 = [&](int a, int b) {
            const Vec3f d = positions[f[size_t(a)]] - positions[f[size_t(b)]];
            return glm::dot(d, d);
        };
        if (f.size() == 3) {
            body.mesh.triangles.push_back({f[0], f[1], f[2]});
        } else if (diagonal2(0, 2) <= diagonal2(1, 3)) {
            body.mesh.triangles.push_back({f[0], f[1], f[2]});
            body.mesh.triangles.push_back({f[0], f[2], f[3]});
        } else {
            body.mesh.triangles.push_back({f[0], f[1], f[3]});
            body.mesh.triangles.push_back({f[1], f[2], f[3]});
        }
    }
    body.mesh.layers = {{"body", "body", 0, kHm08BodyVertices, 0, uint32_t(body.mesh.triangles.size())}};

    // Drop a root without skin weights above the hips ("Root" on the floor, a handle for animators): the hips become the root.
    std::vector<bool> dropped(rig.bones.size(), false);
    const auto children = [&](const std::string& name) {
        return std::count_if(rig.bones.begin(), rig.bones.end(), [&](const MakeHumanBone& b) { return b.parent == name; });
    };
    if (const auto weights = rig.weights.find(rig.bones[0].name);
        (weights == rig.weights.end() || weights->second.empty()) && children(rig.bones[0].name) == 1)
        dropped[0] = true;
    std::vector<uint32_t> jointOfBone(rig.bones.size(), 0), boneOfJoint;
    for (size_t b = 0; b < rig.bones.size(); ++b) {
        if (dropped[b]) continue;
        const MakeHumanBone& bone = rig.bones[b];
        jointOfBone[b] = uint32_t(body.joints.size());
        boneOfJoint.push_back(uint32_t(b));
        body.joints.push_back({bone.name, findJoint(body.joints, bone.parent), meanOf(positions, bone.headVertices), ""});
    }
    assignHumanoidBones(body.joints);
    DPL_RETURN_IF_ERROR(addSkin(rig, jointOfBone, body));
    addKeypoints(source, positions, body);

    for (const MorphRecipe& recipe : recipes()) {
        std::vector<Vec3f> offsets(sourceCount, Vec3f(0));
        for (const TargetPair& pair : recipe.pairs) {
            DPL_RETURN_IF_ERROR(addTarget(root, pair.positive, 0.5f * recipe.scale * pair.weight, offsets));
            DPL_RETURN_IF_ERROR(addTarget(root, pair.negative, -0.5f * recipe.scale * pair.weight, offsets));
        }
        const float lift = meanOf(offsets, soles).y;  // keep the feet on the floor
        for (Vec3f& o : offsets) o.y -= lift;
        ShapeMorph morph{recipe.name, recipe.minValue, recipe.maxValue, {offsets.begin(), offsets.begin() + kHm08BodyVertices}, {}};
        for (const uint32_t b : boneOfJoint) morph.jointOffsets.push_back(meanOf(offsets, rig.bones[b].headVertices));
        body.morphs.push_back(std::move(morph));
    }
    DPL_RETURN_IF_ERROR(checkBody(body));
    return body;
}

}  // namespace dpl
