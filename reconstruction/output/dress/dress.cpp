// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/dress/dress.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "reconstruction/output/dress/body_change.h"
#include "reconstruction/output/dress/layer_part.h"
#include "reconstruction/output/dress/refit.h"
#include "reconstruction/output/dress/seen_skin.h"
#include "reconstruction/output/dress/splat_fill.h"
#include "reconstruction/output/package/avatar_bytes.h"
#include "reconstruction/output/package/sh_palette.h"
#include "reconstruction/subject/garments/cloth_weights.h"
#include "reconstruction/subject/garments/clothed_mesh.h"
#include "reconstruction/subject/garments/resting_hands.h"
#include "reconstruction/training/trainer/init.h"
#include "sdk/core/task.h"
#include "sdk/format/avatar_file.h"
#include "sdk/format/correctives.h"
#include "sdk/format/face_nodes.h"

namespace dpl {
namespace {

constexpr std::string_view kPutOn = ", put on from ";

size_t rankOf(const std::string& layer) {
    return size_t(std::find(kDressLayers.begin(), kDressLayers.end(), layer) - kDressLayers.begin());
}

std::string layerNames(const AvatarData& avatar) {
    std::string out;
    for (const LayerData& layer : avatar.mesh.layers) out += (out.empty() ? "" : ", ") + layer.name;
    return out;
}

size_t layerIndex(const AvatarData& avatar, const std::string& name) {
    const auto& layers = avatar.mesh.layers;
    return size_t(std::find_if(layers.begin(), layers.end(), [&](const LayerData& l) { return l.name == name; }) - layers.begin());
}

/** The avatar has a body layer first and clothes of its own. */
Status checkLayered(const NamedAvatar& named) {
    const auto& layers = named.avatar.mesh.layers;
    if (layers.size() < 2)
        return fail(Code::InvalidArgument,
                    "{}: its clothes are part of its body (one layer), so none can be taken off or lent; reconstruct its scan with label "
                    "pictures",
                    named.file);
    if (layers.front().role != "body")
        return fail(Code::InvalidArgument, "{}: its first layer is '{}' and not the body; reconstruct its scan again", named.file,
                    layers.front().name);
    return {};
}

/** Same rig, same mesh of the body, same splat settings. */
Status checkMatch(const NamedAvatar& wearer, const NamedAvatar& from) {
    const AvatarData &a = wearer.avatar, &b = from.avatar;
    constexpr const char* kFix = "reconstruct both scans with the same --body";
    if (a.joints.size() != b.joints.size())
        return fail(Code::InvalidArgument, "{} has {} joints, {} has {}: garments move only between avatars on the same rig; {}", from.file,
                    b.joints.size(), wearer.file, a.joints.size(), kFix);
    for (size_t j = 0; j < a.joints.size(); ++j)
        if (a.joints[j].name != b.joints[j].name || a.joints[j].parent != b.joints[j].parent)
            return fail(Code::InvalidArgument,
                        "joint {} is '{}' in {} and '{}' in {}: garments move only between avatars on the same rig; {}", j,
                        b.joints[j].name, from.file, a.joints[j].name, wearer.file, kFix);
    const LayerData &bodyA = a.mesh.layers.front(), &bodyB = b.mesh.layers.front();
    const bool same = bodyA.vertexCount == bodyB.vertexCount && bodyA.triangleCount == bodyB.triangleCount &&
                      std::equal(a.mesh.triangles.begin(), a.mesh.triangles.begin() + bodyA.triangleCount, b.mesh.triangles.begin());
    if (!same)
        return fail(Code::InvalidArgument, "the bodies of {} and {} have different meshes ({} and {} vertices); {}", from.file, wearer.file,
                    bodyB.vertexCount, bodyA.vertexCount, kFix);
    if (a.kappaPx2 != b.kappaPx2 || a.compensated != b.compensated)
        return fail(Code::InvalidArgument, "{} was trained with another low-pass than {}; reconstruct it again with this version",
                    from.file, wearer.file);
    return {};
}

/** 1 for vertices that already lie on the wrong side of a neighbour on the avatar they come from: each garment runs on below its
 *  neighbours, so that no gap opens. */
std::vector<uint8_t> tuckedVertices(const AvatarData& avatar, const LayerPart& part) {
    const SurfaceMesh own = part.surface();
    const std::vector<Vec3f> normals = vertexNormals(own.positions, own.triangles);
    std::vector<uint8_t> tucked(own.positions.size(), 0);
    for (size_t layer = 1; layer < avatar.mesh.layers.size(); ++layer) {
        const std::string& name = avatar.mesh.layers[layer].name;
        if (name == part.name || rankOf(name) == kDressLayers.size()) continue;
        const GarmentCover cover(takeLayer(avatar, layer).surface());
        for (size_t v = 0; v < tucked.size(); ++v)
            if (const auto height = cover.heightOf(own.positions[v], normals[v]))
                tucked[v] |= (height->aboveM < 0) == (rankOf(name) < rankOf(part.name));
    }
    return tucked;
}

/** Pose correctives of a new garment: none, but near a kept garment those of it, so that the two stay in order. What the garment's own
 *  avatar learned follows other modes of other poses, and one file has one set of modes. */
void followNeighbours(std::span<const LayerPart> kept, uint16_t zeroNode, LayerPart& part) {
    constexpr float kReachM = 0.06f;  // from a kept garment, where its correctives have faded
    const size_t count = part.mesh.restPositions.size();
    part.nodeIndices.assign(count, glm::u16vec4(zeroNode));
    part.nodeWeights.assign(count, {255, 0, 0, 0});
    std::vector<float> share(count, 0.0f);
    for (const LayerPart& other : kept.subspan(1)) {
        const ClosestSurface surface(other.mesh.restPositions, other.mesh.triangles);
        for (size_t v = 0; v < count; ++v) {
            const SurfacePoint near = surface.find(part.mesh.restPositions[v], kReachM);
            const float here = near.found() ? std::min(1.0f, 1.5f * (1 - near.distanceM / kReachM)) : 0;
            if (here <= share[v]) continue;
            share[v] = here;
            const glm::vec3& w = near.barycentric;
            const int corner = w.x >= w.y && w.x >= w.z ? 0 : w.y >= w.z ? 1 : 2;
            const uint32_t from = other.mesh.triangles[near.triangle][corner];
            // The three heaviest nodes of the closest vertex; the zero node takes the rest.
            std::array<int, 4> order{0, 1, 2, 3};
            std::sort(order.begin(), order.end(), [&](int a, int b) { return other.nodeWeights[from][a] > other.nodeWeights[from][b]; });
            int left = 255;
            for (int k = 0; k < 3; ++k) {
                const int weight = std::min(left, int(std::lround(here * float(other.nodeWeights[from][order[size_t(k)]]))));
                part.nodeIndices[v][k] = other.nodeIndices[from][order[size_t(k)]];
                part.nodeWeights[v][k] = uint8_t(weight);
                left -= weight;
            }
            part.nodeIndices[v][3] = zeroNode;
            part.nodeWeights[v][3] = uint8_t(left);
        }
    }
}

/** Refits a part to the wearer, who wears `worn` (body first) and none of the part's name. */
Result<DressedLayer> fitPart(const NamedAvatar& wearer, std::span<const LayerPart> worn, const Garment& garment, LayerPart& part,
                             Jobs& jobs) {
    const MeshData& body = worn.front().mesh;
    const LayerPart oldBody = takeLayer(garment.from->avatar, 0);
    const SurfaceMesh old = part.surface();
    DPL_TRY(CarriedGarment carried, carryGarment(old, oldBody.mesh.restPositions, body.restPositions, body.triangles));
    SurfaceMesh fitted{std::move(carried.positions), old.triangles};
    const ClosestSurface bodySurface(body.restPositions, body.triangles);
    Obstacles obstacles{bodySurface, {}, {}, tuckedVertices(garment.from->avatar, part)};
    for (const LayerPart& other : worn.subspan(1)) {
        if (rankOf(other.name) == kDressLayers.size()) continue;  // not known whether it goes over or under
        (rankOf(other.name) < rankOf(part.name) ? obstacles.below : obstacles.above).emplace_back(other.surface());
    }
    DressedLayer done{part.name, garment.from->file, garment.from->avatar.name, false, uint32_t(part.mesh.triangles.size()), 0, 0, 0};
    DPL_TRY(done.insideBody, pushOut(obstacles, carried.clearanceM, fitted));
    for (size_t v = 0; v < old.positions.size(); ++v)
        done.meanMoveM += glm::length(fitted.positions[v] - old.positions[v]) / float(old.positions.size());
    std::vector<Mat3x4f> atRest;
    jointTransforms(wearer.avatar.joints, Pose::rest(wearer.avatar.joints.size()), atRest);
    const std::vector<SurfacePoint> below = wornBodyBelow(fitted, body, wearer.avatar.joints, body.restPositions);
    DPL_TRY(ClothWeights weights, clothWeights(fitted, below, body, wearer.avatar.joints, atRest, jobs));
    part.mesh.jointIndices = std::move(weights.joints);
    part.mesh.jointWeights = std::move(weights.weights);
    movePart(std::move(fitted.positions), part);
    return done;
}

/** Pushes the garments that go over `part` out of it, where there was no room for it below them. */
Status liftOver(const AvatarData& wearer, const LayerPart& part, std::span<LayerPart> worn) {
    const MeshData& body = worn.front().mesh;
    for (LayerPart& other : worn.subspan(1)) {
        if (rankOf(other.name) == kDressLayers.size() || rankOf(other.name) < rankOf(part.name)) continue;
        const ClosestSurface bodySurface(body.restPositions, body.triangles);
        Obstacles obstacles{bodySurface, {}, {}, tuckedVertices(wearer, other)};
        obstacles.below.emplace_back(part.surface());
        SurfaceMesh lifted = other.surface();
        const std::vector<float> anywhere(lifted.positions.size(), -1.0f);  // its distance from the body is its own
        DPL_TRY([[maybe_unused]] const uint32_t inside, pushOut(obstacles, anywhere, lifted));
        movePart(std::move(lifted.positions), other);
    }
    return {};
}

/** Fills cloth that shows now and that the body or other clothes hid on the avatar it comes from. shown: of its triangles, now. */
void mendUncovered(const Garment& garment, Marks shown, LayerPart& part, Jobs& jobs) {
    const AvatarData& from = garment.from->avatar;
    const LayerData& layer = from.mesh.layers[layerIndex(from, garment.layer)];
    const LayerPart body = takeLayer(from, 0);
    const Marks before =
        shownTriangles({from.mesh.restPositions, from.mesh.triangles}, body.mesh, Marks(body.mesh.triangles.size(), 1), jobs);
    Marks uncovered = grown(std::move(shown), triangleNeighbours(part.mesh), 1);  // the views may miss a narrow strip
    for (uint32_t t = 0; t < layer.triangleCount; ++t) uncovered[t] &= uint8_t(!before[layer.firstTriangle + t]);
    mendGarment(uncovered, part);
}

/** Which garments the evidence names: those that are worn. */
void updateEvidence(const std::vector<DressedLayer>& layers, std::vector<EvidenceData>& evidence) {
    for (const DressedLayer& layer : layers) {
        const std::string part = "garment layer: " + layer.layer;
        std::erase_if(evidence, [&](const EvidenceData& row) { return row.part == part; });
        evidence.push_back({part, true, 0, 0,
                            formatText("{} triangles{}{} ({})", layer.triangles, kPutOn,
                                       std::filesystem::path(layer.file).filename().string(), layer.avatar)});
    }
}

/** The name of who wears the garments that nameOfDressed() added to it. */
std::string undressed(const std::string& name) {
    const bool dressed = std::ranges::any_of(kDressLayers, [&](const char* layer) { return name.ends_with(formatText("'s {}", layer)); });
    return dressed ? name.substr(0, name.rfind(" in ")) : name;
}

/** "ada in ben's top and cleo's bottom": who wears whose garments, by the evidence of an avatar that was dressed before, or is now. */
std::string nameOfDressed(const std::string& wearer, const std::vector<EvidenceData>& evidence) {
    std::string name = undressed(wearer);
    std::vector<std::string> garments;
    for (const char* layer : kDressLayers)
        for (const EvidenceData& row : evidence) {
            const size_t file = row.reason.find(kPutOn), open = row.reason.find(" (", file);
            if (row.part != std::string("garment layer: ") + layer || file == std::string::npos || open == std::string::npos) continue;
            const std::string from = row.reason.substr(open + 2, row.reason.rfind(')') - open - 2);
            garments.push_back(formatText("{}'s {}", undressed(from), layer));
        }
    for (size_t i = 0; i < garments.size(); ++i) name += (i == 0 ? " in " : i + 1 == garments.size() ? " and " : ", ") + garments[i];
    return name;
}

}  // namespace

Result<Dressed> dressAvatar(const NamedAvatar& wearer, std::span<const Garment> garments, Jobs& jobs) {
    if (garments.empty())
        return fail(Code::InvalidArgument, "nothing to put on {}: name a garment's avatar with --top, --bottom, --shoes or --hair",
                    wearer.file);
    DPL_RETURN_IF_ERROR(checkLayered(wearer));
    for (const Garment& garment : garments) {
        DPL_RETURN_IF_ERROR(checkLayered(*garment.from));
        DPL_RETURN_IF_ERROR(checkMatch(wearer, *garment.from));
        if (layerIndex(garment.from->avatar, garment.layer) == garment.from->avatar.mesh.layers.size())
            return fail(Code::InvalidArgument, "{} has no layer '{}'; it has {}", garment.from->file, garment.layer,
                        layerNames(garment.from->avatar));
    }

    std::vector<Garment> inOrder(garments.begin(), garments.end());
    std::sort(inOrder.begin(), inOrder.end(), [](const Garment& a, const Garment& b) { return rankOf(a.layer) < rankOf(b.layer); });
    Dressed out;
    std::vector<LayerPart> worn;  // what stays on
    for (size_t layer = 0; layer < wearer.avatar.mesh.layers.size(); ++layer) {
        const std::string& name = wearer.avatar.mesh.layers[layer].name;
        const bool off = std::any_of(inOrder.begin(), inOrder.end(), [&](const Garment& g) { return layer > 0 && g.layer == name; });
        if (!off) worn.push_back(takeLayer(wearer.avatar, layer));
    }
    const size_t kept = worn.size();
    AvatarData& avatar = out.avatar;
    avatar = wearer.avatar;
    PoseCorrectiveData& correctives = avatar.correctives;
    shareFaceNodes(avatar.expressions);  // new layers follow nodes of the face too
    // Nodes of expressions alone begin with one that never moves.
    const auto zeroNode = uint16_t(correctives.followsPose() ? correctives.nodeCount : 0);
    if (correctives.followsPose()) {
        if (correctives.nodeCount == kMaxCorrectiveNodes)
            return fail(Code::Unsupported, "{} has as many nodes of pose correctives as a file can hold; reconstruct it at a lower preset",
                        wearer.file);
        ++correctives.nodeCount;
        correctives.nodes.resize(size_t(correctives.nodeCount) * correctives.columnCount(), Vec4f(0));
    }
    size_t newTriangles = 0;
    for (size_t i = 0; i < inOrder.size(); ++i) {
        const Garment& garment = inOrder[i];
        DPL_RETURN_IF_ERROR(taskAt(0.1 + 0.5 * double(i) / double(inOrder.size()), "fitting " + garment.layer));
        LayerPart part = takeLayer(garment.from->avatar, layerIndex(garment.from->avatar, garment.layer));
        DPL_TRY(DressedLayer done, fitPart(wearer, worn, garment, part, jobs));
        done.replaced = layerIndex(wearer.avatar, garment.layer) < wearer.avatar.mesh.layers.size();
        out.layers.push_back(std::move(done));
        DPL_RETURN_IF_ERROR(liftOver(wearer.avatar, part, worn));
        if (!correctives.empty()) followNeighbours(std::span<const LayerPart>(worn).first(kept), zeroNode, part);
        newTriangles += part.mesh.triangles.size();
        worn.push_back(std::move(part));
    }

    DPL_RETURN_IF_ERROR(taskAt(0.6, "skin that the change uncovers"));
    const BodyChange change = changeBody(wearer.avatar, kept, worn, jobs);
    out.filledSkinTriangles = change.filledTriangles, out.clearedSkinTriangles = change.clearedTriangles, out.noSkin = change.noSkin;
    for (size_t i = kept, first = change.shown.size() - newTriangles; i < worn.size(); ++i) {
        const auto begin = change.shown.begin() + long(first), end = begin + long(worn[i].mesh.triangles.size());
        mendUncovered(inOrder[i - kept], Marks(begin, end), worn[i], jobs);
        out.layers[i - kept].splats = worn[i].splats.count();
        first += worn[i].mesh.triangles.size();
    }
    joinLayers(worn, avatar);
    separateLayers(avatar.mesh);
    avatar.generator = "doppel dress";
    updateEvidence(out.layers, avatar.evidence);
    avatar.name = nameOfDressed(wearer.avatar.name, avatar.evidence);
    DPL_RETURN_IF_ERROR(taskAt(0.9, "encoding"));

    sortSplats(avatar);
    const std::vector<Vec3f> exact = avatar.mesh.restPositions;
    DPL_TRY(const AvatarData decoded, decodedAvatar(avatar));
    avatar.mesh = decoded.mesh;  // the vertices that every reader decodes
    DPL_TRY([[maybe_unused]] const uint32_t unchanged, rebaseSplats(exact, avatar));
    DPL_TRY(avatar, decodedAvatar(avatar));
    return out;
}

Result<DressedFile> dressFiles(const std::filesystem::path& wearer, std::span<const GarmentFile> garments, Jobs& jobs) {
    WriteOptions options{.shPalette = true};
    const auto read = [&](const std::filesystem::path& path) -> Result<NamedAvatar> {
        DPL_TRY(const auto bytes, readAvatarBytes(path));
        auto avatar = readAvatar(bytes);
        if (!avatar) return fail(avatar.error().code, "{}: {}", path.string(), avatar.error().message);
        if (path == wearer) {
            DPL_TRY(const AvatarInfo info, inspectAvatar(bytes));
            options.compact = info.splatEncoding == 3;
        }
        return NamedAvatar{path.string(), std::move(*avatar)};
    };
    DPL_TRY(const NamedAvatar onto, read(wearer));
    std::map<std::filesystem::path, NamedAvatar> sources;  // a file that lends several garments is read once
    for (const GarmentFile& garment : garments) {
        if (sources.contains(garment.path)) continue;
        DPL_TRY(NamedAvatar source, read(garment.path));
        sources.emplace(garment.path, std::move(source));
    }
    std::vector<Garment> lent;
    for (const GarmentFile& garment : garments) lent.push_back({garment.layer, &sources.at(garment.path)});
    DressedFile out;
    DPL_TRY(out.dressed, dressAvatar(onto, lent, jobs));
    if (out.dressed.avatar.splats.shDegree > 0) {  // as doppel reconstruct writes them
        DPL_TRY([[maybe_unused]] const ShPaletteReport palette, paletteSh(out.dressed.avatar.splats, kAvatarPalette, jobs));
    }
    DPL_TRY(out.bytes, writeAvatar(out.dressed.avatar, options));
    return out;
}

}  // namespace dpl
