// SPDX-License-Identifier: Apache-2.0
// Garments of one procedural person on another: fitted, outside the body, with their splats, and no holes in the skin.
#include "reconstruction/output/dress/dress.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include <gtest/gtest.h>

#include "reconstruction/output/dress/layer_part.h"
#include "reconstruction/output/package/sh_palette.h"
#include "reconstruction/subject/garments/garment_cover.h"
#include "reconstruction/subject/sample/subject.h"
#include "reconstruction/subject/shape/closest_surface.h"
#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"
#include "sdk/math/sh.h"
#include "tests/unit/heard_task.h"
#include "tests/unit/recon_dress/cut_layer.h"

namespace dpl {
namespace {

const Vec3f kSkin(0.8f, 0.6f, 0.5f);

Vec3f colourOf(const std::string& layer, uint64_t seed) {
    if (layer == "body") return kSkin;
    return {layer == "top" ? 0.9f : 0.1f, 0.1f * float(seed), layer == "bottom" ? 0.9f : 0.2f};
}

/** A procedural person as an avatar: one splat on each triangle that shows, coloured by layer; two modes of pose correctives that move
 *  every vertex by 2 cm. */
NamedAvatar person(uint64_t seed, uint32_t shDegree = 0) {
    Jobs jobs(2);
    const Subject subject = makeSubject(seed, jobs);
    NamedAvatar out{"person-" + std::to_string(seed) + ".glb", {}};
    AvatarData& a = out.avatar;
    a.name = subject.name, a.joints = subject.joints, a.mesh = subject.mesh;
    a.mesh.colours.resize(a.mesh.restPositions.size(), glm::u8vec4(128, 128, 128, 255));
    SplatData& s = a.splats;
    s.shDegree = shDegree;
    s.triangleStart = {0};
    for (const LayerData& layer : a.mesh.layers)
        for (uint32_t t = layer.firstTriangle; t < layer.firstTriangle + layer.triangleCount; ++t) {
            if (!subject.hiddenFace[t]) {
                s.uv.push_back({1 / 3.0f, 1 / 3.0f}), s.phi.push_back(0), s.scaleM.push_back({0.008f, 0.008f});
                s.opacity.push_back(0.9f), s.flags.push_back(layer.name == "body" ? 0 : kSplatCloth);
                const Vec3f sh = (colourOf(layer.name, seed) - 0.5f) / float(kShC0);
                s.sh.resize(s.sh.size() + 3 * size_t(shCoefficientCount(shDegree)), 0.0f);
                std::copy_n(&sh.x, 3, s.sh.end() - long(3 * size_t(shCoefficientCount(shDegree))));
            }
            s.triangleStart.push_back(s.count());
        }
    PoseCorrectiveData& c = a.correctives;
    c.modeCount = 1, c.nodeCount = 1, c.joints = {1}, c.mean.assign(6, 0.0f), c.modes = {1, 0, 0, 0, 0, 0}, c.reach = 4;
    c.nodeIndices.assign(a.mesh.restPositions.size(), glm::u16vec4(0));
    c.nodeWeights.assign(a.mesh.restPositions.size(), glm::u8vec4(255, 0, 0, 0));
    c.nodes = {Vec4f(0.02f, 0, 0, 0)};
    a.evidence = {{"garment layer: top", true, 0, 0, "its own"}};
    sortSplats(a);
    auto decoded = decodedAvatar(a);
    EXPECT_TRUE(bool(decoded)) << (decoded ? "" : decoded.error().message);
    a = std::move(*decoded);
    return out;
}

const NamedAvatar& first() {
    static const NamedAvatar made = person(1);
    return made;
}

const NamedAvatar& second() {
    static const NamedAvatar made = person(2);
    return made;
}

LayerPart partOf(const AvatarData& avatar, const std::string& name) {
    for (size_t i = 0; i < avatar.mesh.layers.size(); ++i)
        if (avatar.mesh.layers[i].name == name) return takeLayer(avatar, i);
    ADD_FAILURE() << "no layer " << name;
    return {};
}

Dressed dress(const NamedAvatar& wearer, const std::vector<Garment>& garments, uint32_t threads = 2) {
    Jobs jobs(threads);
    auto dressed = dressAvatar(wearer, garments, jobs);
    EXPECT_TRUE(bool(dressed)) << (dressed ? "" : dressed.error().message);
    return dressed ? std::move(*dressed) : Dressed{};
}

/** The first person in the second one's top and bottom. */
const Dressed& exchanged() {
    static const Dressed made = dress(first(), {{"top", &second()}, {"bottom", &second()}});
    return made;
}

std::string refusal(const NamedAvatar& wearer, const std::vector<Garment>& garments) {
    Jobs jobs(1);
    const auto dressed = dressAvatar(wearer, garments, jobs);
    EXPECT_FALSE(bool(dressed));
    return dressed ? "" : dressed.error().message;
}

size_t insideBody(const AvatarData& avatar, const std::string& layer) {
    const LayerPart body = takeLayer(avatar, 0), part = partOf(avatar, layer);
    const ClosestSurface surface(body.mesh.restPositions, body.mesh.triangles);
    size_t inside = 0;
    for (const Vec3f& p : part.mesh.restPositions) inside += surface.signedDistance(p, 0.2f) < 0;
    return inside;
}

/** The person grown by `factor`, with everything that it wears. */
NamedAvatar grown(NamedAvatar person, float factor) {
    for (Vec3f& p : person.avatar.mesh.restPositions) p *= factor;
    for (JointData& joint : person.avatar.joints) joint.restPosition *= factor;
    return person;
}

float heightOf(const LayerPart& part) {
    float low = 1e9f, high = -1e9f;
    for (const Vec3f& p : part.mesh.restPositions) low = std::min(low, p.y), high = std::max(high, p.y);
    return high - low;
}

TEST(Dress, theSameBodyGetsTheSameGarment) {
    const Dressed dressed = dress(first(), {{"top", &first()}, {"shoes", &first()}});
    for (const char* layer : {"top", "shoes"}) {
        const LayerPart before = partOf(first().avatar, layer), after = partOf(dressed.avatar, layer);
        ASSERT_EQ(before.mesh.restPositions.size(), after.mesh.restPositions.size());
        float largest = 0;
        for (size_t v = 0; v < before.mesh.restPositions.size(); ++v)
            largest = std::max(largest, glm::length(before.mesh.restPositions[v] - after.mesh.restPositions[v]));
        EXPECT_LT(largest, 1e-3f) << layer;
        EXPECT_EQ(before.splats.count(), after.splats.count()) << layer;
    }
}

TEST(Dress, theNameSaysWhoWearsWhat) {
    NamedAvatar ada = first(), ben = second();
    ada.avatar.name = "ada", ben.avatar.name = "ben";
    NamedAvatar dressed{"new.glb", dress(ada, {{"top", &ben}, {"shoes", &ben}}).avatar};
    EXPECT_EQ(dressed.avatar.name, "ada in ben's shoes and ben's top");
    ada.avatar.name = "cleo";
    EXPECT_EQ(dress(dressed, {{"top", &ada}}).avatar.name, "ada in ben's shoes and cleo's top") << "dressed again";
    ada.avatar.name = "ada in Rome", ben.avatar.name = "ben (2)";
    EXPECT_EQ(dress(ada, {{"top", &ben}}).avatar.name, "ada in Rome in ben (2)'s top") << "her name is no garment";
}

TEST(Dress, anotherBodyWearsTheGarmentOutside) {
    const Dressed& dressed = exchanged();
    for (const DressedLayer& layer : dressed.layers) {
        EXPECT_TRUE(layer.replaced);
        EXPECT_EQ(layer.insideBody, 0u) << layer.layer;
        EXPECT_EQ(insideBody(dressed.avatar, layer.layer), 0u) << layer.layer;
    }
    EXPECT_EQ(dressed.avatar.mesh.layers.size(), first().avatar.mesh.layers.size());
}

TEST(Dress, aGarmentGrowsWithABodyTenPercentLarger) {
    const NamedAvatar large = grown(first(), 1.1f);
    const Dressed dressed = dress(large, {{"top", &first()}});
    EXPECT_EQ(insideBody(dressed.avatar, "top"), 0u);
    const LayerPart before = partOf(first().avatar, "top"), after = partOf(dressed.avatar, "top");
    EXPECT_NEAR(heightOf(after) / heightOf(before), 1.1f, 0.02f);
    double ratio = 0;
    for (uint32_t i = 0; i < before.splats.count(); ++i)
        ratio += std::sqrt(double(after.splats.scaleM[i].x * after.splats.scaleM[i].y)) / 0.008 / before.splats.count();
    EXPECT_GT(ratio, 1.05);  // of the splats' sizes; loose cloth keeps its distance in metres, so the girth grows by less
    EXPECT_LT(ratio, 1.11);
}

TEST(Dress, theOldGarmentGoesWithItsSplats) {
    const Dressed& dressed = exchanged();
    const LayerPart top = partOf(dressed.avatar, "top"), lent = partOf(second().avatar, "top");
    EXPECT_EQ(top.mesh.triangles, lent.mesh.triangles);
    const float green = 0.5f + float(kShC0) * top.splats.sh[1];
    EXPECT_NEAR(green, 0.2f, 0.01f);  // the second person's
    EXPECT_EQ(partOf(dressed.avatar, "shoes").splats.count(), partOf(first().avatar, "shoes").splats.count());
    const auto& evidence = dressed.avatar.evidence;
    ASSERT_EQ(evidence.size(), 2u);
    EXPECT_NE(evidence[0].reason.find("person-2.glb"), std::string::npos) << evidence[0].reason;
}

TEST(Dress, uncoveredSkinIsFilledFromTheSkinAround) {
    // A top without sleeves: all that lies more than 16 cm beside the middle is cut off.
    NamedAvatar vest = second();
    test::cutLayer(
        "top", [](const Vec3f& p) { return std::abs(p.x) <= 0.16f; }, vest.avatar);
    const Dressed dressed = dress(first(), {{"top", &vest}});
    EXPECT_GT(dressed.filledSkinTriangles, 100u);
    EXPECT_FALSE(dressed.noSkin);
    // The upper arms: the first person's sleeves hid them, and now they are bare.
    const LayerPart body = takeLayer(dressed.avatar, 0), before = takeLayer(first().avatar, 0);
    size_t bare = 0, wasEmpty = 0;
    for (size_t t = 0; t < body.mesh.triangles.size(); ++t) {
        const Vec3f& p = body.mesh.restPositions[body.mesh.triangles[t].x];
        if (std::abs(p.x) < 0.24f || std::abs(p.x) > 0.3f || p.y < 1.0f) continue;
        ++bare;
        wasEmpty += before.splats.triangleStart[t] == before.splats.triangleStart[t + 1];
        ASSERT_LT(body.splats.triangleStart[t], body.splats.triangleStart[t + 1]) << "a hole at " << p.x << ", " << p.y;
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(0.5f + float(kShC0) * body.splats.sh[body.splats.triangleStart[t] * 3 + uint32_t(c)], kSkin[c], 0.02f);
    }
    EXPECT_GT(bare, 50u);
    EXPECT_GT(wasEmpty, 20u);
}

TEST(Dress, aTightTopIsLiftedOverANewBottom) {
    // A wearer without trousers, whose top lies 2 mm above the skin: a bottom with its own distance finds no room below it.
    NamedAvatar tight{"tight.glb", first().avatar};
    std::vector<LayerPart> parts;
    for (size_t i = 0; i < tight.avatar.mesh.layers.size(); ++i)
        if (tight.avatar.mesh.layers[i].name != "bottom") parts.push_back(takeLayer(tight.avatar, i));
    const ClosestSurface skin(parts[0].mesh.restPositions, parts[0].mesh.triangles);
    for (LayerPart& part : parts)
        if (part.name == "top")
            for (Vec3f& p : part.mesh.restPositions) {
                const SurfacePoint foot = skin.find(p);
                p = foot.position + 0.002f * skin.normalAt(foot);
            }
    joinLayers(parts, tight.avatar);
    const Dressed dressed = dress(tight, {{"bottom", &second()}});
    EXPECT_FALSE(dressed.layers[0].replaced);
    const LayerPart top = partOf(dressed.avatar, "top");
    const GarmentCover cover(partOf(dressed.avatar, "bottom").surface());
    const auto normals = vertexNormals(top.mesh.restPositions, top.mesh.triangles);
    size_t over = 0, under = 0;
    for (size_t v = 0; v < normals.size(); ++v)
        if (const auto height = cover.heightOf(top.mesh.restPositions[v], normals[v])) ++(height->aboveM > 0 ? over : under);
    EXPECT_GT(over, 50u);
    EXPECT_LT(under, over / 50);
}

TEST(Dress, aNewGarmentTakesNoCorrectivesOfOtherClothes) {
    const Dressed& dressed = exchanged();
    const PoseCorrectiveData& c = dressed.avatar.correctives;
    ASSERT_EQ(c.nodeCount, 2u);
    EXPECT_EQ(c.nodes[1], Vec4f(0));
    const LayerPart top = partOf(dressed.avatar, "top"), hair = partOf(dressed.avatar, "hair");
    size_t still = 0;
    for (size_t v = 0; v < top.nodeIndices.size(); ++v) {
        if (top.mesh.restPositions[v].y > 1.1f && top.mesh.restPositions[v].y < 1.3f) {  // far from trousers and hair
            ASSERT_EQ(top.nodeIndices[v][0], 1) << v;
            ++still;
        }
    }
    EXPECT_GT(still, 100u);
    for (const glm::u16vec4& node : hair.nodeIndices) ASSERT_EQ(node[0], 0);  // kept
}

TEST(Dress, refusesWhatItCannotFitAndNamesTheFile) {
    NamedAvatar bare{"bare.glb", first().avatar};
    const LayerPart body = takeLayer(first().avatar, 0);
    joinLayers(std::vector<LayerPart>{body}, bare.avatar);
    EXPECT_NE(refusal(bare, {{"top", &second()}}).find("bare.glb: its clothes are part of its body"), std::string::npos);
    EXPECT_NE(refusal(first(), {{"top", &bare}}).find("label pictures"), std::string::npos);

    NamedAvatar other{"other.glb", second().avatar};
    other.avatar.mesh.layers[2].name = "cape";
    const std::string missing = other.avatar.mesh.layers[2].name == "cape" ? second().avatar.mesh.layers[2].name : "";
    EXPECT_NE(refusal(first(), {{missing, &other}}).find("other.glb has no layer '" + missing + "'; it has body"), std::string::npos);

    NamedAvatar renamed{"renamed.glb", second().avatar};
    renamed.avatar.joints[5].name = "tail";
    const std::string rig = refusal(first(), {{"top", &renamed}});
    EXPECT_NE(rig.find("'tail' in renamed.glb"), std::string::npos) << rig;
    EXPECT_NE(rig.find("same --body"), std::string::npos) << rig;

    NamedAvatar turned{"turned.glb", second().avatar};
    std::swap(turned.avatar.mesh.triangles[0].x, turned.avatar.mesh.triangles[0].y);
    EXPECT_NE(refusal(first(), {{"top", &turned}}).find("different meshes"), std::string::npos);
    EXPECT_NE(refusal(first(), {}).find("--top"), std::string::npos);
}

TEST(Dress, aCancelledRunSaysSo) {
    Jobs jobs(1);
    test::HeardTask task(1);
    const TaskScope scope(&task);
    const auto stopped = dressAvatar(first(), std::vector<Garment>{{"top", &second()}}, jobs);
    ASSERT_FALSE(bool(stopped));
    EXPECT_EQ(stopped.error().code, Code::Cancelled);
}

TEST(Dress, movedSplatsFollowStretchAndTurnOfTheirTriangle) {
    LayerPart part;
    part.mesh.restPositions = {{0, 0, 0}, {0.1f, 0, 0}, {0, 0.1f, 0}};
    part.mesh.triangles = {{0, 1, 2}};
    SplatData& s = part.splats;
    s.triangleStart = {0, 1}, s.uv = {{0.3f, 0.3f}}, s.phi = {0}, s.scaleM = {{0.02f, 0.01f}}, s.opacity = {1}, s.flags = {0};
    s.shDegree = 1;
    s.sh.assign(12, 0.0f);
    s.sh[3 * 3] = 1;                                           // the band that follows x
    movePart({{0, 0, 0}, {0, 0.3f, 0}, {-0.1f, 0, 0}}, part);  // a quarter turn about z; the first axis three times as long
    EXPECT_NEAR(s.scaleM[0].x, 0.06f, 1e-5f);
    EXPECT_NEAR(s.scaleM[0].y, 0.01f, 1e-5f);
    EXPECT_NEAR(s.sh[3 * 3], 0, 1e-5f);
    EXPECT_NEAR(std::abs(s.sh[1 * 3]), 1, 1e-5f);  // now it follows y
}

TEST(Dress, filesAreNamedInErrorsAndThreadsChangeNothing) {
    const std::filesystem::path folder = std::filesystem::temp_directory_path() / "doppel-dress-test";
    std::filesystem::create_directories(folder);
    AvatarData shiny = first().avatar;  // its light follows the view, on each splat in another way
    SplatData& s = shiny.splats;
    const std::vector<float> still = std::exchange(s.sh, std::vector<float>(size_t(s.count()) * 12));
    s.shDegree = 1;
    for (size_t i = 0; i < s.count(); ++i) {
        std::copy_n(&still[3 * i], 3, &s.sh[12 * i]);
        for (size_t k = 3; k < 12; ++k) s.sh[12 * i + k] = 0.002f * float((i * k) % 17);
    }
    shiny = *decodedAvatar(shiny);
    ASSERT_TRUE(bool(writeFileAtomically(folder / "a.glb", *writeAvatar(shiny))));
    const std::string text = "no avatar";
    ASSERT_TRUE(bool(writeFileAtomically(folder / "b.glb", std::vector<uint8_t>(text.begin(), text.end()))));
    Jobs jobs(1);
    const auto wrong = dressFiles(folder / "a.glb", std::vector<GarmentFile>{{"top", folder / "b.glb"}}, jobs);
    ASSERT_FALSE(bool(wrong));
    EXPECT_NE(wrong.error().message.find("b.glb"), std::string::npos) << wrong.error().message;
    const NamedAvatar lender{(folder / "a.glb").string(), shiny};
    const auto right = dressFiles(folder / "a.glb", std::vector<GarmentFile>{{"hair", folder / "a.glb"}}, jobs);
    ASSERT_TRUE(bool(right)) << right.error().message;
    AvatarData dressed = dress(lender, {{"hair", &lender}}, 3).avatar;
    const auto palette = paletteSh(dressed.splats, kAvatarPalette, jobs);
    ASSERT_TRUE(bool(palette));
    EXPECT_GT(palette->entries, 1u);
    EXPECT_LT(palette->entries, 17u) << "of 17 different rows";
    const auto same = writeAvatar(dressed, {.shPalette = true});
    ASSERT_TRUE(bool(same));
    EXPECT_EQ(right->bytes, *same);  // one thread and three
    std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace dpl
