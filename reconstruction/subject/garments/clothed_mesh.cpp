// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/garments/clothed_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "reconstruction/subject/garments/body_layer.h"
#include "reconstruction/subject/garments/cloth_weights.h"
#include "reconstruction/subject/garments/hanging_hair.h"
#include "reconstruction/subject/garments/leg_gap.h"
#include "reconstruction/subject/garments/priors.h"
#include "reconstruction/subject/garments/resting_hands.h"
#include "reconstruction/subject/garments/silhouette_hull.h"
#include "reconstruction/subject/shape/closest_surface.h"
#include "reconstruction/subject/surface/mesh_raster.h"
#include "reconstruction/subject/surface/priors.h"
#include "sdk/core/task.h"
#include "sdk/format/check_mesh.h"
#include "sdk/math/skinning.h"

namespace dpl {
namespace {

constexpr const char* kHair = "hair";
constexpr double kLabelSmoothingM = 0.008;  // of the votes
constexpr float kNudgeM = 2e-5f;            // between vertices of two layers at the same position

Status checkView(const GarmentInput& input, const GarmentView& view, size_t i) {
    const size_t pixels = size_t(view.camera.widthPx) * view.camera.heightPx;
    if (view.mask.pixels.size() != pixels || view.mask.widthPx != view.camera.widthPx)
        return fail(Code::InvalidArgument, "the mask of view {} is {} x {}, its camera {} x {}", i, view.mask.widthPx, view.mask.heightPx,
                    view.camera.widthPx, view.camera.heightPx);
    if (!view.labels.pixels.empty() && (view.labels.pixels.size() != pixels || view.labels.widthPx != view.camera.widthPx))
        return fail(Code::InvalidArgument, "the labels of view {} are {} x {}, its camera {} x {}", i, view.labels.widthPx,
                    view.labels.heightPx, view.camera.widthPx, view.camera.heightPx);
    return checkPose(input.joints, view.pose);
}

Status checkInput(const GarmentInput& input) {
    const size_t count = input.body.restPositions.size();
    if (count == 0 || input.body.triangles.empty()) return fail(Code::InvalidArgument, "the body to dress is empty");
    DPL_RETURN_IF_ERROR(checkRig(input.joints));
    DPL_RETURN_IF_ERROR(checkMesh(input.body, input.joints.size()));
    DPL_RETURN_IF_ERROR(checkFinite(input.body));
    if (input.bodyOffsets.size() != count)
        return fail(Code::InvalidArgument, "{} offsets for {} vertices of the body", input.bodyOffsets.size(), count);
    for (const Vec3f& o : input.bodyOffsets)
        if (!std::isfinite(o.x + o.y + o.z)) return fail(Code::InvalidArgument, "an offset of the body is not finite");
    for (const auto views : {input.views, input.moving})
        for (size_t i = 0; i < views.size(); ++i) DPL_RETURN_IF_ERROR(checkView(input, views[i], i));
    return {};
}

std::vector<Vec3f> offsetPositions(const MeshData& mesh, std::span<const Vec3f> offsets) {
    std::vector<Vec3f> at = mesh.restPositions;
    for (size_t v = 0; v < at.size(); ++v) at[v] += offsets[v];
    return at;
}

/** Everything in one still pose. */
struct StillBody {
    StillViews still;
    std::vector<Mat3x4f> worldFromRest;
    std::vector<Vec3f> posed;    // the fitted body
    std::vector<Vec3f> clothed;  // with all offsets
};

double meanIou(const SurfaceMesh& hull, const GarmentInput& input, const StillViews& still, Jobs& jobs) {
    std::vector<double> iou(input.views.size(), 0);
    jobs.forBlocks(iou.size(), [&](size_t i, uint32_t) {
        iou[i] = silhouetteIou(rasteriseMesh(hull.positions, hull.triangles, still.cameras[i]), input.views[i].mask.pixels);
    });
    double sum = 0;
    for (double value : iou) sum += value / double(iou.size());
    return sum;
}

/** The body's layer alone, with the given offsets. */
ClothedMesh bodyLayer(const GarmentInput& input, std::span<const Vec3f> offsets) {
    ClothedMesh out;
    out.mesh = input.body;
    out.mesh.restPositions = offsetPositions(input.body, offsets);
    out.mesh.layers = {{"body", "body", 0, uint32_t(input.body.restPositions.size()), 0, uint32_t(input.body.triangles.size())}};
    out.triangleLabel.assign(input.body.triangles.size(), votingLabels(input.labels)[0].value);
    return out;
}

void appendLayer(ClothedMesh& clothed, const ScanLabel& label, const MeshData& garment) {
    MeshData& mesh = clothed.mesh;
    const std::vector<Vec3f>& rest = garment.restPositions;
    const std::vector<Triangle>& triangles = garment.triangles;
    const auto firstVertex = uint32_t(mesh.restPositions.size()), firstTriangle = uint32_t(mesh.triangles.size());
    const bool coloured = mesh.colours.size() == mesh.restPositions.size();
    mesh.restPositions.insert(mesh.restPositions.end(), rest.begin(), rest.end());
    mesh.jointIndices.insert(mesh.jointIndices.end(), garment.jointIndices.begin(), garment.jointIndices.end());
    mesh.jointWeights.insert(mesh.jointWeights.end(), garment.jointWeights.begin(), garment.jointWeights.end());
    if (coloured) mesh.colours.resize(mesh.restPositions.size(), glm::u8vec4(128, 128, 128, 255));
    for (const Triangle& t : triangles) mesh.triangles.push_back(t + firstVertex);
    clothed.triangleLabel.resize(mesh.triangles.size(), label.value);
    mesh.layers.push_back({label.name, label.name == kHair ? "hair" : "garment", firstVertex, uint32_t(rest.size()), firstTriangle,
                           uint32_t(triangles.size())});
}

/** A garment at rest with its skin weights. */
struct WornGarment {
    MeshData mesh;
    std::vector<Vec3f> still;  // its vertices in the still pose
    float largestWeightStep = 0;
};

/** The clothed surface in the still pose, and the garments that are cut from it. */
struct Outside {
    SurfaceMesh hull;
    std::vector<uint32_t> column;  // of each hull vertex: the label with most votes
    GarmentPieces taken;
    std::map<uint32_t, WornGarment> worn;  // by column, once asked for
};

/** fitted: the posed body. */
Result<Outside> outsideOf(SurfaceMesh hull, const ScalarField& field, const ClosestSurface& fitted, const GarmentInput& input,
                          const StillBody& body, Jobs& jobs) {
    Outside out{std::move(hull), {}, {}, {}};
    DPL_TRY(LabelField votes, voteLabels(out.hull, input.views, body.still.cameras, input.labels, kLabelSmoothingM, jobs));
    for (size_t v = 0; v < out.hull.positions.size(); ++v) out.column.push_back(votes.best(v));
    const std::vector<float> underside = hemUndersides(out.hull, votes, field, fitted);
    out.taken = takeGarments(out.hull, std::move(votes), underside, {});
    return out;
}

Result<const WornGarment*> garmentAsWorn(Outside& outside, const GarmentPiece& piece, const GarmentInput& input, const StillBody& body,
                                         Jobs& jobs) {
    if (const auto known = outside.worn.find(piece.column); known != outside.worn.end()) return &known->second;
    const auto [mesh, below] = withArmsApart(piece.mesh, input.body, input.joints, body.posed);
    DPL_TRY(ClothWeights weights, clothWeights(mesh, below, input.body, input.joints, body.worldFromRest, jobs));
    if (votingLabels(input.labels)[piece.column].name == kHair) hangFromHead(mesh, input.joints, body.worldFromRest, weights);
    WornGarment& worn = outside.worn[piece.column];
    worn.mesh.restPositions = unposed(mesh, weights, body.worldFromRest);
    worn.mesh.jointIndices = std::move(weights.joints), worn.mesh.jointWeights = std::move(weights.weights);
    worn.mesh.triangles = mesh.triangles, worn.still = mesh.positions;
    worn.largestWeightStep = weights.largestStep;
    return &worn;
}

/** Gives two legs to the garments of `outside` that moving pictures show parted. meshed: the hull of a field, in the still pose. */
Result<std::vector<LegDecision>> partLegs(const GarmentInput& input, const StillBody& body, const ClosestSurface& fitted,
                                          const ScalarField& field, const std::function<SurfaceMesh(const ScalarField&)>& meshed,
                                          Outside& outside, Jobs& jobs) {
    std::vector<LegDecision> decisions;
    const LegGap gap(input.body, input.joints, body.posed);
    const std::vector<ScanLabel> labels = votingLabels(input.labels);
    std::vector<uint8_t> apart(labels.size(), 0);  // of each column: cloth with that label is parted
    for (const GarmentPiece& piece : outside.taken.pieces)
        apart[piece.column] =
            std::any_of(piece.mesh.positions.begin(), piece.mesh.positions.end(), [&](const Vec3f& p) { return gap(p) > 0; });
    const auto none = [&] { return std::count(apart.begin() + 1, apart.end(), uint8_t(1)) == 0; };
    if (input.moving.empty() || none()) return decisions;
    apart[0] = 1;  // bare legs
    const ClosestSurface surface(outside.hull.positions, outside.hull.triangles);
    const auto parts = [&](const Vec3f& p) {
        const SurfacePoint at = surface.find(p);
        int nearest = 0;
        for (int c = 1; c < 3; ++c)
            if (at.barycentric[c] > at.barycentric[nearest]) nearest = c;
        return apart[outside.column[outside.hull.triangles[at.triangle][nearest]]] != 0;
    };
    const auto withLegs = [&]() -> Result<Outside> {
        const ScalarField parted = [&](const Vec3f& p) {
            const float value = field(p);
            const float slab = value < 0 ? gap(p) : value;
            return slab > value && parts(p) ? slab : value;
        };
        SurfaceMesh hull = meshed(parted);
        gap.close(hull, parts);
        return outsideOf(std::move(hull), parted, fitted, input, body, jobs);
    };
    DPL_TRY(Outside parted, withLegs());
    bool same = true;
    for (const GarmentPiece& joined : outside.taken.pieces) {
        if (!apart[joined.column]) continue;
        const ScanLabel& label = labels[joined.column];
        decisions.push_back({label.name, {}});
        const auto other = std::find_if(parted.taken.pieces.begin(), parted.taken.pieces.end(),
                                        [&](const GarmentPiece& piece) { return piece.column == joined.column; });
        if (other != parted.taken.pieces.end()) {
            DPL_TRY(const WornGarment* one, garmentAsWorn(outside, joined, input, body, jobs));
            DPL_TRY(const WornGarment* two, garmentAsWorn(parted, *other, input, body, jobs));
            const std::vector<uint8_t> between = gap.between(one->still, one->mesh.triangles);
            decisions.back().seen =
                betweenLegs({one->mesh, between, two->mesh, label.value, labels[0].value}, input.joints, input.moving, jobs);
        }
        if (!decisions.back().seen.parted()) apart[joined.column] = 0, same = false;
    }
    if (none()) return decisions;
    if (!same) {
        DPL_TRY(parted, withLegs());
    }
    outside = std::move(parted);
    return decisions;
}

/** How sure the pictures are that each body vertex is skin: votes on the posed single skin. */
Result<std::vector<float>> skinShare(const GarmentInput& input, const StillBody& body, Jobs& jobs) {
    const SurfaceMesh skin{body.clothed, input.body.triangles};
    DPL_TRY(const LabelField field, voteLabels(skin, input.views, body.still.cameras, input.labels, kLabelSmoothingM, jobs));
    std::vector<float> share(skin.positions.size());
    for (size_t v = 0; v < share.size(); ++v) share[v] = field.seen[v] > 0.02f ? field.score[v * field.columns()] : 0;
    return share;
}

}  // namespace

void separateLayers(MeshData& mesh) {
    std::set<std::tuple<float, float, float>> taken;
    for (const LayerData& layer : mesh.layers) {
        std::vector<Vec3f*> own;
        for (uint32_t v = layer.firstVertex; v < layer.firstVertex + layer.vertexCount; ++v) own.push_back(&mesh.restPositions[v]);
        for (Vec3f* p : own)
            while (taken.contains({p->x, p->y, p->z})) p->y += kNudgeM;
        for (const Vec3f* p : own) taken.insert({p->x, p->y, p->z});
    }
}

Result<GarmentFit> makeClothedMesh(const GarmentInput& input, Jobs& jobs) {
    DPL_RETURN_IF_ERROR(checkInput(input));
    const auto report = [&](double share) { return taskAt(share, formatText("{} still pictures", input.views.size())); };
    GarmentFit fit;
    const auto oneLayer = [&](std::string why) {
        fit.clothed = bodyLayer(input, input.bodyOffsets);
        for (GarmentDecision& decision : fit.decisions)
            if (decision.reason.empty()) decision.reason = why;
        fit.summary = "one layer, clothes are part of the body's surface: " + std::move(why);
        return fit;
    };
    const std::vector<ScanLabel> labels = votingLabels(input.labels);
    for (size_t c = 1; c < labels.size(); ++c) fit.decisions.push_back({labels[c], false, "", 0, 0});
    const auto labelled = std::count_if(input.views.begin(), input.views.end(), [](const auto& v) { return !v.labels.pixels.empty(); });
    if (labels.size() < 2) return oneLayer("the scan names no clothing labels");
    if (labelled == 0) return oneLayer("no still picture has labels");
    if (input.views.size() < priors::kFewestHullViews)
        return oneLayer(formatText("{} still pictures are too few for the shape of clothes; {} are needed", input.views.size(),
                                   priors::kFewestHullViews));

    StillBody body;
    body.still = compensateSway(input.joints, input.views);
    jointTransforms(input.joints, body.still.pose, body.worldFromRest);
    skin(input.body, body.worldFromRest, jobs, body.posed);
    skin(input.body, offsetPositions(input.body, input.bodyOffsets), body.worldFromRest, jobs, body.clothed);
    Vec3f low(1e30f), high(-1e30f);
    for (const Vec3f& p : body.posed) low = glm::min(low, p), high = glm::max(high, p);
    const Vec3f margin(float(priors::kMaxOffsetM), 0.15f, float(priors::kMaxOffsetM));
    const SilhouetteField field(input.views, body.still.cameras, jobs);
    const ScalarField hullField = [&](const Vec3f& p) { return field(p); };
    const auto meshed = [&](const ScalarField& of) { return meshHull(of, low - margin, high + margin, {}, jobs); };
    SurfaceMesh hull = field.empty() ? SurfaceMesh{} : meshed(hullField);
    if (hull.triangles.empty()) return oneLayer("the masks of the still pictures have no common shape");
    DPL_RETURN_IF_ERROR(report(0.3));
    fit.hullIou = meanIou(hull, input, body.still, jobs);
    const ClosestSurface fitted(body.posed, input.body.triangles);
    DPL_TRY(Outside outside, outsideOf(std::move(hull), hullField, fitted, input, body, jobs));
    DPL_RETURN_IF_ERROR(report(0.5));
    DPL_TRY(fit.legs, partLegs(input, body, fitted, hullField, meshed, outside, jobs));
    GarmentPieces& taken = outside.taken;
    fit.decisions = std::move(taken.decisions);
    if (taken.pieces.empty()) return oneLayer("no label is worth a layer of its own");
    DPL_RETURN_IF_ERROR(report(0.7));

    // The body: offsets where skin was seen, then below the garments.
    DPL_TRY(const std::vector<float> skinSeen, skinShare(input, body, jobs));
    DPL_TRY(std::vector<Vec3f> offsets, skinOffsets(input.body, input.bodyOffsets, skinSeen));
    std::vector<Vec3f> posed;
    skin(input.body, offsetPositions(input.body, offsets), body.worldFromRest, jobs, posed);
    std::vector<SurfaceMesh> covers;
    for (const GarmentPiece& piece : taken.pieces) covers.push_back(piece.mesh);
    DPL_TRY(const std::vector<Vec3f> push, pushBelow(posed, input.body.triangles, covers, float(priors::kBodyBelowClothM)));
    for (size_t v = 0; v < offsets.size(); ++v) {
        const Mat3x4f blended = blendedTransform(input.body.jointIndices[v], input.body.jointWeights[v], body.worldFromRest.data());
        const Mat3f linear(blended[0], blended[1], blended[2]);
        if (std::abs(glm::determinant(linear)) > 0.05f) offsets[v] += glm::inverse(linear) * push[v];
    }
    fit.clothed = bodyLayer(input, offsets);
    DPL_RETURN_IF_ERROR(report(0.8));

    size_t vertices = 0, inside = 0;
    const ClosestSurface restBody(fit.clothed.mesh.restPositions, input.body.triangles);
    for (const GarmentPiece& piece : taken.pieces) {
        DPL_TRY(const WornGarment* garment, garmentAsWorn(outside, piece, input, body, jobs));
        for (const Vec3f& p : garment->mesh.restPositions) inside += restBody.signedDistance(p, 0.1f) < 0;
        vertices += garment->mesh.restPositions.size();
        fit.largestWeightStep = std::max(fit.largestWeightStep, garment->largestWeightStep);
        appendLayer(fit.clothed, labels[piece.column], garment->mesh);
    }
    fit.insideBody = double(inside) / double(vertices);
    separateLayers(fit.clothed.mesh);
    DPL_RETURN_IF_ERROR(checkFinite(fit.clothed.mesh));
    fit.summary = formatText("{} layers beside the body", taken.pieces.size());
    for (const LegDecision& legs : fit.legs)
        if (legs.seen.parted()) fit.summary += formatText("; {} has two legs", legs.name);
    return fit;
}

}  // namespace dpl
