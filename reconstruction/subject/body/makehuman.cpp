// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/makehuman.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>

#include "reconstruction/subject/body/body_tools.h"
#include "reconstruction/subject/body/makehuman_files.h"
#include "sdk/avatar/humanoid.h"
#include "sdk/format/skin_weights.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

constexpr float kMetresPerDm = 0.1f;
constexpr uint32_t kHm08BodyVertices = 13380;  // vertices [0, 13380) of hm08 are skin; the rest are helpers and joint cubes
constexpr float kLashShare = 0.25f;            // of their length in MakeHuman
constexpr glm::u8vec4 kSkinColour(214, 172, 146, 255), kMouthColour(70, 26, 26, 255);

struct FacePart {
    const char* group;
    glm::u8vec4 colour;
};
constexpr FacePart kFaceParts[] = {
    {"helper-l-eye", {232, 226, 220, 255}},       {"helper-r-eye", {232, 226, 220, 255}},      {"helper-upper-teeth", {226, 217, 200, 255}},
    {"helper-lower-teeth", {226, 217, 200, 255}}, {"helper-tongue", {168, 84, 84, 255}},       {"helper-l-eyelashes-1", {38, 28, 24, 255}},
    {"helper-l-eyelashes-2", {38, 28, 24, 255}},  {"helper-r-eyelashes-1", {38, 28, 24, 255}}, {"helper-r-eyelashes-2", {38, 28, 24, 255}}};

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

/** Index in the body of a vertex of the base mesh, or -1. */
std::vector<int32_t> bodyIndices(std::span<const MakeHumanVertex> vertices, size_t sourceCount) {
    std::vector<int32_t> index(sourceCount, -1);
    for (size_t i = 0; i < vertices.size(); ++i) index[vertices[i].vertex] = int32_t(i);
    return index;
}

void addFaces(const std::vector<std::vector<uint32_t>>& faces, std::span<const int32_t> indexOf, MeshData& mesh) {
    for (const auto& face : faces) {
        std::array<uint32_t, 4> f{};
        bool whole = true;
        for (size_t i = 0; i < face.size(); ++i) {
            whole = whole && indexOf[face[i]] >= 0;
            f[i] = uint32_t(std::max(0, indexOf[face[i]]));
        }
        if (!whole) continue;
        const auto diagonal2 = [&](size_t a, size_t b) {
            const Vec3f d = mesh.restPositions[f[a]] - mesh.restPositions[f[b]];
            return glm::dot(d, d);
        };
        if (face.size() == 3) {
            mesh.triangles.push_back({f[0], f[1], f[2]});
        } else if (diagonal2(0, 2) <= diagonal2(1, 3)) {
            mesh.triangles.push_back({f[0], f[1], f[2]});
            mesh.triangles.push_back({f[0], f[2], f[3]});
        } else {
            mesh.triangles.push_back({f[0], f[1], f[3]});
            mesh.triangles.push_back({f[1], f[2], f[3]});
        }
    }
}

/** The skin of the cavity of the mouth: what hangs together behind the lips. */
std::vector<uint32_t> mouthSkin(const MakeHumanMesh& source, std::span<const Vec3f> positions) {
    constexpr uint32_t kBack = 710, kLip = 474;  // hm08: the back of the cavity; the middle of the upper lip's edge
    constexpr float kBehindLipM = 0.004f, kCornerBehindM = 0.0077f, kCornerM = 0.026f;
    std::vector<std::vector<uint32_t>> neighbours(kHm08BodyVertices);
    for (const auto& f : source.faces.at("body"))
        for (size_t i = 0; i < f.size(); ++i)
            if (const uint32_t a = f[i], b = f[(i + 1) % f.size()]; a < kHm08BodyVertices && b < kHm08BodyVertices)
                neighbours[a].push_back(b), neighbours[b].push_back(a);
    std::vector<uint32_t> found = {kBack};
    std::vector<uint8_t> known(kHm08BodyVertices, 0);
    known[kBack] = 1;
    for (size_t i = 0; i < found.size(); ++i)
        for (const uint32_t to : neighbours[found[i]]) {
            const float x = positions[to].x / kCornerM;
            if (known[to] || positions[to].z >= positions[kLip].z - kBehindLipM - kCornerBehindM * x * x) continue;
            known[to] = 1, found.push_back(to);
        }
    return found;
}

/** Paints what the body is without pictures: lips and lids like skin, irises, a dark mouth. */
void addColours(const MakeHumanMesh& source, std::span<const Vec3f> positions, std::span<const int32_t> indexOf, MeshData& mesh) {
    constexpr float kPupilCos = 0.970f, kIrisCos = 0.89f;  // of the angle to the middle of the pupil: 14° and 27°
    constexpr glm::u8vec4 kPupil(14, 10, 8, 255), kIris(92, 66, 44, 255);
    mesh.colours.assign(mesh.restPositions.size(), kSkinColour);
    for (const uint32_t v : mouthSkin(source, positions)) mesh.colours[v] = kMouthColour;
    for (const FacePart& part : kFaceParts) {
        const auto group = source.groups.find(part.group);
        if (group == source.groups.end()) continue;
        const bool eye = std::string_view(part.group).ends_with("-eye");
        const Vec3f centre = meanOf(positions, group->second);
        for (const uint32_t v : group->second) {
            if (indexOf[v] < 0) continue;
            const Vec3f out = positions[v] - centre;
            const float forwards = out.z / std::max(glm::length(out), 1e-9f);
            mesh.colours[size_t(indexOf[v])] = !eye || forwards < kIrisCos ? part.colour : forwards < kPupilCos ? kIris : kPupil;
        }
    }
}

void addKeypoints(const MakeHumanMesh& source, std::span<const Vec3f> positions, std::span<const int32_t> indexOf, BodyModel& body) {
    body.keypoints = deriveKeypoints(body);
    // hm08 vertices: tip of the nose, tragus of each ear, crown.
    const std::pair<const char*, uint32_t> vertices[] = {{"nose", 297}, {"ear_l", 12038}, {"ear_r", 5439}, {"head_top", 881}};
    for (const auto& [name, vertex] : vertices)
        for (BodyKeypoint& k : body.keypoints)
            if (k.name == name) k = {name, {{vertex, 1.0f}}, {}};
    const std::pair<const char*, const char*> eyes[] = {{"eye_l", "helper-l-eye"}, {"eye_r", "helper-r-eye"}};
    for (const auto& [name, group] : eyes) {
        const auto eye = source.groups.find(group);
        if (eye == source.groups.end() || eye->second.empty()) continue;
        const uint32_t pupil = *std::max_element(eye->second.begin(), eye->second.end(),
                                                 [&](uint32_t a, uint32_t b) { return positions[a].z < positions[b].z; });
        std::erase_if(body.keypoints, [&, name = name](const BodyKeypoint& k) { return k.name == name; });
        body.keypoints.push_back({name, {{uint32_t(indexOf[pupil]), 1.0f}}, {}});
    }
}

/** The joints of the face in the body; -1: it has none. */
struct FaceJoints {
    int32_t head = -1, leftEye = -1, rightEye = -1, jaw = -1;
};

/** Skin weights. What follows the head alone is shared with the jaw; eyeballs follow their eyes, skin of the lids never does. */
Status addSkin(const MakeHumanMesh& source, const MakeHumanRig& rig, const std::vector<uint32_t>& jointOfBone,
               std::span<const MakeHumanVertex> vertices, const MakeHumanFaceRig* faceRig, const FaceJoints& joints, BodyModel& body) {
    std::vector<std::vector<std::pair<uint32_t, float>>> influences(source.positionsDm.size());
    for (size_t b = 0; b < rig.bones.size(); ++b)
        if (const auto weights = rig.weights.find(rig.bones[b].name); weights != rig.weights.end())
            for (const auto& [vertex, weight] : weights->second) {
                const bool onHead = faceRig && int32_t(jointOfBone[b]) == joints.head;
                const auto share = onHead ? faceRig->withJaw.find(vertex) : std::map<uint32_t, float>::const_iterator{};
                const float jaw = onHead && share != faceRig->withJaw.end() ? share->second : 0;
                if (weight * (1 - jaw) > 0) influences[vertex].emplace_back(jointOfBone[b], weight * (1 - jaw));
                if (weight * jaw > 0) influences[vertex].emplace_back(uint32_t(joints.jaw), weight * jaw);
            }
    for (const auto& [group, joint] : {std::pair{"helper-l-eye", joints.leftEye},
                                       {"helper-r-eye", joints.rightEye},
                                       {"helper-lower-teeth", joints.jaw},
                                       {"helper-tongue", joints.jaw}})
        if (const auto part = source.groups.find(group); joint >= 0 && part != source.groups.end())
            for (const uint32_t v : part->second) influences[v] = {{uint32_t(joint), 1.0f}};
    for (const MakeHumanVertex& vertex : vertices) {
        const auto& from = influences[vertex.root];
        if (from.empty()) return fail(Code::CorruptData, "the rig gives vertex {} of the skin no weight", vertex.root);
        const PackedWeights packed = packWeights(from);
        body.mesh.jointIndices.push_back(packed.joints);
        body.mesh.jointWeights.push_back(packed.weights);
    }
    return {};
}

/** The folder of MakeHuman's default rig, beside the data or in the folder that holds it; empty: there is none. */
fs::path faceRigFolder(const fs::path& folder, const fs::path& root) {
    for (const fs::path& at : {folder / "rig-makehuman", root.parent_path() / "rig-makehuman"})
        if (fs::exists(at / "default.mhskel") && fs::exists(at / "default_weights.mhw")) return at;
    return {};
}

}  // namespace

std::vector<MakeHumanVertex> makeHumanVertices(const MakeHumanMesh& mesh) {
    std::vector<MakeHumanVertex> vertices;
    for (uint32_t v = 0; v < kHm08BodyVertices; ++v) vertices.push_back({v, v, 1});
    for (const FacePart& part : kFaceParts) {
        const auto group = mesh.groups.find(part.group);
        if (group == mesh.groups.end()) continue;
        const bool lashes = std::string_view(part.group).find("lashes") != std::string_view::npos;
        for (const uint32_t v : group->second) {
            if (v < kHm08BodyVertices) continue;
            const auto distance2 = [&](uint32_t skin) {
                const Vec3f d = mesh.positionsDm[skin] - mesh.positionsDm[v];
                return glm::dot(d, d);
            };
            uint32_t nearest = 0;
            for (uint32_t skin = 1; lashes && skin < kHm08BodyVertices; ++skin)
                if (distance2(skin) < distance2(nearest)) nearest = skin;
            vertices.push_back(lashes ? MakeHumanVertex{v, nearest, kLashShare} : MakeHumanVertex{v, v, 1});
        }
    }
    return vertices;
}

Result<fs::path> makeHumanRoot(const fs::path& folder) {
    for (const fs::path& root : {folder, folder / "mpfb2"})
        if (fs::exists(root / "3dobjs" / "base.obj")) return root;
    return fail(Code::NotFound, "{}: no 3dobjs/base.obj here or in mpfb2/; give the MakeHuman / MPFB2 data folder", folder.string());
}

Status addMakeHumanTarget(const fs::path& root, const std::string& name, float factor, std::vector<Vec3f>& offsetsM) {
    fs::path path = root / "targets" / (name + ".target.gz");
    if (!fs::exists(path)) path.replace_extension();  // .target.gz -> .target
    DPL_TRY(const auto rows, readMakeHumanTarget(path, offsetsM.size()));
    for (const TargetRow& row : rows) offsetsM[row.vertex] += factor * kMetresPerDm * row.offsetDm;
    return {};
}

Result<BodyModel> importMakeHuman(const fs::path& folder, const MakeHumanOptions& options) {
    DPL_TRY(const fs::path root, makeHumanRoot(folder));
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
    for (const TargetPair& t : kNeutral) DPL_RETURN_IF_ERROR(addMakeHumanTarget(root, t.positive, t.weight, positions));
    const std::vector<uint32_t> soles = soleVertices(positions);
    const float ground = meanOf(positions, soles).y;
    for (Vec3f& p : positions) p.y -= ground;

    BodyModel body;
    body.name = "makehuman-" + options.rig;
    const std::vector<MakeHumanVertex> vertices = makeHumanVertices(source);
    const std::vector<int32_t> indexOf = bodyIndices(vertices, sourceCount);
    for (const MakeHumanVertex& v : vertices) body.mesh.restPositions.push_back(v.of(positions));
    addFaces(source.faces.at("body"), indexOf, body.mesh);
    for (const FacePart& part : kFaceParts)
        if (const auto faces = source.faces.find(part.group); faces != source.faces.end()) addFaces(faces->second, indexOf, body.mesh);
    addColours(source, positions, indexOf, body.mesh);
    body.mesh.layers = {{"body", "body", 0, uint32_t(vertices.size()), 0, uint32_t(body.mesh.triangles.size())}};

    // Drop a root without skin weights above the hips ("Root" on the floor, a handle for animators): the hips become the root.
    std::vector<bool> dropped(rig.bones.size(), false);
    const auto children = [&](const std::string& name) {
        return std::count_if(rig.bones.begin(), rig.bones.end(), [&](const MakeHumanBone& b) { return b.parent == name; });
    };
    if (const auto weights = rig.weights.find(rig.bones[0].name);
        (weights == rig.weights.end() || weights->second.empty()) && children(rig.bones[0].name) == 1)
        dropped[0] = true;
    std::vector<uint32_t> jointOfBone(rig.bones.size(), 0);
    std::vector<std::vector<uint32_t>> placeOfJoint;  // the vertices whose mean it is
    for (size_t b = 0; b < rig.bones.size(); ++b) {
        if (dropped[b]) continue;
        const MakeHumanBone& bone = rig.bones[b];
        jointOfBone[b] = uint32_t(body.joints.size());
        placeOfJoint.push_back(bone.headVertices);
        body.joints.push_back({bone.name, findJoint(body.joints, bone.parent), meanOf(positions, bone.headVertices), ""});
    }
    FaceJoints joints{.head = findJoint(body.joints, "head")};
    std::optional<MakeHumanFaceRig> faceRig;
    if (const fs::path faceFolder = faceRigFolder(folder, root); !faceFolder.empty() && joints.head >= 0) {
        DPL_TRY(faceRig, readMakeHumanFaceRig(faceFolder, source));
        const auto add = [&](const char* name, const std::vector<uint32_t>& place) {
            placeOfJoint.push_back(place);
            body.joints.push_back({name, joints.head, meanOf(positions, place), ""});
            return int32_t(body.joints.size()) - 1;
        };
        joints.leftEye = add("eye_l", faceRig->leftEye), joints.rightEye = add("eye_r", faceRig->rightEye);
        joints.jaw = add("jaw", faceRig->jaw);
    }
    assignHumanoidBones(body.joints);
    DPL_RETURN_IF_ERROR(addSkin(source, rig, jointOfBone, vertices, faceRig ? &*faceRig : nullptr, joints, body));
    addKeypoints(source, positions, indexOf, body);

    for (const MorphRecipe& recipe : recipes()) {
        std::vector<Vec3f> offsets(sourceCount, Vec3f(0));
        for (const TargetPair& pair : recipe.pairs) {
            DPL_RETURN_IF_ERROR(addMakeHumanTarget(root, pair.positive, 0.5f * recipe.scale * pair.weight, offsets));
            DPL_RETURN_IF_ERROR(addMakeHumanTarget(root, pair.negative, -0.5f * recipe.scale * pair.weight, offsets));
        }
        const float lift = meanOf(offsets, soles).y;  // keep the feet on the floor
        for (Vec3f& o : offsets) o.y -= lift;
        ShapeMorph morph{recipe.name, recipe.minValue, recipe.maxValue, {}, {}};
        for (const MakeHumanVertex& v : vertices) morph.vertexOffsets.push_back(v.of(offsets));
        for (const std::vector<uint32_t>& place : placeOfJoint) morph.jointOffsets.push_back(meanOf(offsets, place));
        body.morphs.push_back(std::move(morph));
    }
    DPL_RETURN_IF_ERROR(checkBody(body));
    return body;
}

}  // namespace dpl
