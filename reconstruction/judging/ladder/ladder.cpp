// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/ladder/ladder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "reconstruction/input/capture/frame_picture.h"
#include "reconstruction/judging/ladder/carried_points.h"
#include "reconstruction/judging/ladder/garment_distance.h"
#include "reconstruction/judging/ladder/light.h"
#include "reconstruction/judging/ladder/rig_fit.h"
#include "reconstruction/judging/ladder/true_mesh.h"
#include "reconstruction/judging/report/fine_truth.h"
#include "reconstruction/judging/report/score.h"
#include "reconstruction/subject/shape/implicit_mesh.h"
#include "reconstruction/subject/surface/mesh_raster.h"
#include "sdk/avatar/posed_mesh.h"
#include "sdk/core/evenly_spaced.h"
#include "sdk/core/task.h"
#include "sdk/splat/splat_engine.h"

namespace dpl {
namespace {

constexpr size_t kTrainFrames = 12;  // scored training frames of a kind, evenly spaced; of the other splits all frames are scored
constexpr double kLightWindows[] = {0.04, 0.012, 0.008};  // σ over the picture's height: 20, 6 and 4 px of 504
constexpr size_t kStillFrames = 12;      // still training frames over which the avatar's surface is compared with the true one
constexpr size_t kFitStride = 3;         // every third vertex pulls in the pose fit
constexpr double kBodyDistanceM = 0.02;  // a vertex this far from the true body weighs half in the pose fit: cloth tells little of bones

constexpr GarmentPoses kGarmentPoses[] = {GarmentPoses::Fitted, GarmentPoses::True};  // rows of each garment

/** The columns of the table. */
constexpr std::pair<FrameKind, Split> kGroups[] = {{FrameKind::StaticFull, Split::Train},   {FrameKind::StaticFull, Split::Validation},
                                                   {FrameKind::StaticFull, Split::Test},    {FrameKind::Dynamic, Split::Train},
                                                   {FrameKind::Dynamic, Split::Validation}, {FrameKind::Dynamic, Split::Test}};

enum Rung : size_t {
    kRegistered,
    kRegisteredGain,
    kPoseFitted,
    kTruePoses,
    kTruePosesPlain,
    kTrueSurface,
    kTrueSurfaceGain,
    kTrueSurfaceLight,
    kTrueSurfaceFineLight,
    kTrueSurfaceFinestLight,
    kNoise,
    kNoiseInside,
    kFlatLabels,
    kTrueMeshColours,
    kRungs
};

Ladder emptyLadder() {
    Ladder ladder;
    ladder.rungs = {
        {"as_is", "as it is, in the registered poses", {}},
        {"as_is_gain", "the same, with the best gain per frame and channel", {}},
        {"pose_fit", "as it is, poses fitted to the pictures", {}},
        {"true_poses", "true poses: the avatar's rig fitted to the true body", {}},
        {"true_poses_plain", "true poses, without pose correctives", {}},
        {"true_surface", "true surface: the avatar's mesh carried by the true body and clothes", {}},
        {"true_surface_gain", "true surface, best gain per frame and channel", {}},
        {"true_surface_light", "true surface, best smooth light per frame", {}},
        {"true_surface_light_fine", "the same, in a window of 1.2 % of the height", {}},
        {"true_surface_light_finest", "the same, in a window of 0.8 % of the height", {}},
        {"noise_floor", "floor: the finer truth in the picture's place", {}},
        {"noise_floor_inside", "the same, one pixel inside the outline", {}},
        {"floor_flat_labels", "floor: one colour a label in the true outline", {}},
        {"floor_true_mesh_colours", "floor: true mesh with vertex colours", {}},
    };
    for (const auto& [kind, split] : kGroups) ladder.groups.push_back({kind, split, 0});
    for (LadderRung& rung : ladder.rungs) rung.cells.resize(ladder.groups.size());
    return ladder;
}

/** Draws the avatar's splats on triangles that the caller poses. */
class Drawer {
public:
    Drawer(const AvatarData& avatar, Jobs& jobs)
        : avatar_(avatar),
          jobs_(jobs),
          engine_(jobs),
          bind_(restTriangles(avatar.mesh)),
          cloth_(avatar.joints, avatar.mesh, avatar.correctives) {
        std::vector<uint32_t> triangle;
        for (size_t t = 0; t + 1 < avatar.splats.triangleStart.size(); ++t)
            triangle.resize(avatar.splats.triangleStart[t + 1], uint32_t(t));
        const SplatData& s = avatar.splats;
        splats_ = PackedSplats(BoundSplatView{triangle, s.uv, s.phi, s.scaleM, s.opacity, s.flags, s.shDegree, s.sh});
    }

    /** Poses the avatar by its rig, with or without its pose correctives. */
    std::vector<Vec3f> pose(const Pose& pose, bool correctives = true) {
        static const PoseCorrectiveData kNone;
        posed_.pose({avatar_.joints, avatar_.mesh, correctives ? avatar_.correctives : kNone, {bind_}, &avatar_.light, {}, &cloth_}, pose,
                    jobs_);
        return {posed_.positions().begin(), posed_.positions().end()};
    }
    /** RGBA with straight alpha. positions: V, world; the light is that of the last pose(). */
    std::vector<uint8_t> draw(std::span<const Vec3f> positions, const Camerad& camera) {
        poseTriangles(avatar_.mesh, {bind_}, positions, jobs_, frames_, posed_.light());
        engine_.project(splats_, frames_, camera.cast<float>(), avatar_.kappaPx2, avatar_.compensated);
        engine_.bin();
        engine_.blendRgba8(rgba_);
        std::vector<uint8_t> out = rgba_;
        for (size_t i = 0; i < out.size(); i += 4)
            for (size_t c = i; c < i + 3 && out[i + 3] > 0; ++c)
                out[c] = uint8_t(std::min(255.0f, float(out[c]) * 255.0f / float(out[i + 3]) + 0.5f));
        return out;
    }

private:
    const AvatarData& avatar_;
    Jobs& jobs_;
    SplatEngine engine_;
    std::vector<RestTriangle<float>> bind_;
    ClothLimits cloth_;
    PackedSplats splats_;
    PosedMesh posed_;
    std::vector<TriangleFrame<float>> frames_;
    std::vector<uint8_t> rgba_;
};

double meanDistanceMm(std::span<const Vec3f> a, std::span<const Vec3f> b) {
    double sum = 0;
    for (size_t v = 0; v < a.size(); ++v) sum += 1000.0 * glm::length(Vec3d(a[v]) - Vec3d(b[v]));
    return a.empty() ? 0 : sum / double(a.size());
}

class LadderRun {
public:
    LadderRun(const LadderInput& in, TrueMesh truth, Jobs& jobs)
        : in_(in), truth_(std::move(truth)), jobs_(jobs), drawer_(in.avatar, jobs), meshColours_(truth_.restPositions.size()) {
        for (size_t t = 0; t < truth_.triangles.size(); ++t)
            if (!truth_.hidden[t]) shown_.push_back(truth_.triangles[t]);
    }

    Result<std::optional<Ladder>> run() {
        std::vector<size_t> stills;
        for (size_t f = 0; f < truth_.frames.size(); ++f)
            if (truth_.frames[f].known && in_.scan.frames[f].kind == FrameKind::StaticFull && splitOf(f) == Split::Train)
                stills.push_back(f);
        if (stills.empty()) return std::optional<Ladder>();
        DPL_RETURN_IF_ERROR(gatherFloors());
        bind(evenlySpaced(stills, kStillFrames), stills);
        Ladder ladder = emptyLadder();
        for (const GarmentPair& garment : garments_)
            for (const GarmentPoses poses : kGarmentPoses)
                ladder.garments.push_back({garment.name, poses, std::vector<GarmentCell>(ladder.groups.size())});
        const std::vector<std::pair<size_t, size_t>> frames = chosenFrames();
        for (size_t i = 0; i < frames.size(); ++i) {
            DPL_RETURN_IF_ERROR(taskAt(0.2 + 0.8 * double(i) / double(frames.size()), in_.scan.frames[frames[i].first].name));
            DPL_RETURN_IF_ERROR(score(frames[i].first, frames[i].second, ladder));
        }
        for (GarmentRow& row : ladder.garments)
            for (GarmentCell& cell : row.cells)
                for (double* sum : {&cell.correctedMm, &cell.plainMm, &cell.pointCorrectedMm, &cell.pointPlainMm})
                    if (cell.frames > 0) *sum /= double(cell.frames);
        for (size_t g = 0; g < ladder.groups.size(); ++g)
            for (LadderRung& rung : ladder.rungs) {
                LadderCell& cell = rung.cells[g];
                if (cell.frames == 0) continue;
                cell.maskedPsnrDb /= double(cell.frames);
                if (cell.surfaceMm) *cell.surfaceMm /= double(cell.frames);
            }
        // A scan without a finer truth has no noise floor, and nothing is said of one.
        std::erase_if(ladder.rungs, [](const LadderRung& rung) {
            return rung.key.starts_with("noise_floor") &&
                   std::all_of(rung.cells.begin(), rung.cells.end(), [](const LadderCell& cell) { return cell.frames == 0; });
        });
        return std::optional<Ladder>(std::move(ladder));
    }

private:
    Split splitOf(size_t f) const { return in_.poses.frames[f].split; }

    /** Frames to score with their column: frames whose true surface is known. */
    std::vector<std::pair<size_t, size_t>> chosenFrames() const {
        std::vector<std::pair<size_t, size_t>> chosen;
        for (size_t g = 0; g < std::size(kGroups); ++g) {
            std::vector<size_t> all;
            const auto [kind, split] = kGroups[g];
            for (size_t f = 0; f < truth_.frames.size(); ++f) {
                if (!truth_.frames[f].known || in_.scan.frames[f].kind != kind) continue;
                if (kind == FrameKind::Dynamic && truth_.frames[f].posed.empty()) continue;
                if (splitOf(f) == split) all.push_back(f);
            }
            for (size_t f : evenlySpaced(all, split == Split::Train ? kTrainFrames : all.size())) chosen.push_back({f, g});
        }
        return chosen;
    }

    /** The colours of both floors, from training frames whose true surface is known. */
    Status gatherFloors() {
        for (size_t f = 0; f < truth_.frames.size(); ++f) {
            const ScanFrame& frame = in_.scan.frames[f];
            if (splitOf(f) != Split::Train || frame.kind == FrameKind::StaticCloseup) continue;
            DPL_RETURN_IF_ERROR(taskAt(0.15 * double(f) / double(truth_.frames.size()), frame.name));
            const auto picture = readFramePicture(frame);
            if (!picture) continue;  // the scan check reports it
            labels_.add(picture->image, picture->mask, picture->labels);
            DPL_TRY(const auto surface, trueSurface(truth_, truth_.frames[f], frame.kind));
            if (surface)
                meshColours_.add(rasteriseMesh(*surface, shown_, in_.cameras[f]), *surface, shown_, in_.cameras[f], picture->image.pixels,
                                 picture->mask.pixels);
        }
        colours_ = meshColours_.finish(shown_);
        return {};
    }

    /** Binds the avatar's vertices to the true surface. The mean over still frames removes their sway. */
    void bind(const std::vector<size_t>& averaged, const std::vector<size_t>& stills) {
        std::vector<uint8_t> seen(truth_.restPositions.size(), 0);
        for (size_t f : stills) {
            const MeshRaster raster = rasteriseMesh(skinnedTruth(truth_, truth_.frames[f]), shown_, in_.cameras[f]);
            for (uint32_t t : raster.triangle)
                if (t != kNoTriangle)
                    for (int c = 0; c < 3; ++c) seen[shown_[t][c]] = 1;
        }
        std::vector<uint8_t> visible, body;
        for (size_t t = 0; t < truth_.triangles.size(); ++t) {
            const Triangle& corner = truth_.triangles[t];
            visible.push_back(!truth_.hidden[t] && (seen[corner.x] || seen[corner.y] || seen[corner.z]));
            body.push_back(!truth_.clothTriangle[t]);
        }
        garments_ = garmentPairs(in_.avatar.mesh, truth_, visible);
        const auto bound = [&](const std::vector<uint8_t>& allowed, bool correctives) {
            std::optional<CarriedPoints> points;
            for (size_t f : averaged) {
                const std::vector<Vec3f> surface = skinnedTruth(truth_, truth_.frames[f]),
                                         ours = drawer_.pose(in_.poses.frames[f].pose, correctives);
                if (!points)
                    points.emplace(ours, vertexNormals(ours, in_.avatar.mesh.triangles), surface, truth_.triangles, allowed, jobs_);
                points->average(ours, surface);
            }
            return std::move(*points);
        };
        std::vector<GarmentPlaces::Still> places;
        for (size_t f : garments_.empty() ? std::vector<size_t>() : averaged) {
            std::vector<Vec3f> ours = drawer_.pose(in_.poses.frames[f].pose), normals = vertexNormals(ours, in_.avatar.mesh.triangles);
            places.push_back({std::move(ours), std::move(normals), skinnedTruth(truth_, truth_.frames[f])});
        }
        for (const GarmentPair& garment : garments_) places_.emplace_back(garment, places, jobs_);
        whole_.emplace(bound(visible, true));
        body_.emplace(bound(body, false));
        const std::vector<float> distances = body_->distancesM();
        for (size_t v = 0; v < distances.size(); ++v) {
            const double relative = distances[v] / kBodyDistanceM;
            weights_.push_back(v % kFitStride == 0 ? float(1 / (1 + relative * relative)) : 0.0f);
        }
    }

    Status score(size_t f, size_t group, Ladder& ladder) {
        const auto picture = readFramePicture(in_.scan.frames[f]);
        if (!picture) return {};
        DPL_TRY(const auto surface, trueSurface(truth_, truth_.frames[f], in_.scan.frames[f].kind));
        if (!surface) return {};
        const ImageRgb8& image = picture->image;
        const ImageGrey8 &mask = picture->mask, &labels = picture->labels;
        const Camerad& camera = in_.cameras[f];
        const FramePose& found = in_.poses.frames[f];
        const std::vector<Vec3f> carried = whole_->at(*surface);
        const auto add = [&](Rung rung, const std::vector<uint8_t>& rgba, std::span<const Vec3f> positions) {
            LadderCell& cell = ladder.rungs[rung].cells[group];
            cell.maskedPsnrDb += scorePicture(rgba, image, mask).maskedPsnrDb;
            ++cell.frames;
            if (!positions.empty()) cell.surfaceMm = cell.surfaceMm.value_or(0) + meanDistanceMm(positions, carried);
        };
        ++ladder.groups[group].frames;
        std::vector<Vec3f> positions = drawer_.pose(found.pose);
        const std::vector<uint8_t> plain = drawer_.draw(positions, camera);
        add(kRegistered, plain, positions);
        add(kRegisteredGain, withBestGain(plain, image, mask), {});
        if (found.fittedPose) {
            positions = drawer_.pose(*found.fittedPose);
            add(kPoseFitted, drawer_.draw(positions, camera), positions);
        }
        const Pose pose =
            fitRig(in_.avatar.joints, in_.avatar.mesh, body_->at(skinnedTruth(truth_, truth_.frames[f])), weights_, found.pose);
        positions = drawer_.pose(pose, false);
        add(kTruePosesPlain, drawer_.draw(positions, camera), positions);
        positions = drawer_.pose(pose);
        add(kTruePoses, drawer_.draw(positions, camera), positions);
        const std::vector<uint8_t> best = drawer_.draw(carried, camera);
        add(kTrueSurface, best, carried);
        add(kTrueSurfaceGain, withBestGain(best, image, mask), {});
        for (size_t w = 0; w < std::size(kLightWindows); ++w)
            add(Rung(kTrueSurfaceLight + w), withBestLight(best, image, mask, kLightWindows[w]), {});
        if (const auto fine = fineTruth(in_.scan.root, in_.scan.frames[f].name, camera)) {
            const uint32_t w = camera.widthPx, h = camera.heightPx;
            const std::vector<uint8_t> reduced = areaAveraged(fine->rgba, fine->widthPx, fine->heightPx, w, h);
            add(kNoise, reduced, {});
            LadderCell& inside = ladder.rungs[kNoiseInside].cells[group];
            inside.maskedPsnrDb += scorePicture(reduced, insideOutline(cutOut(image, mask), w, h), w, h).maskedPsnrDb, ++inside.frames;
        }
        if (!labels.pixels.empty()) add(kFlatLabels, labels_.paint(mask, labels), {});
        add(kTrueMeshColours, paintMesh(*surface, shown_, colours_, camera), {});
        measureGarments({found.bestPose(), pose}, *surface, group, ladder);
        return {};
    }

    /** Adds the distances of all garments from the true surface, in the poses that kGarmentPoses names. */
    void measureGarments(const std::array<Pose, std::size(kGarmentPoses)>& poses, std::span<const Vec3f> surface, size_t group,
                         Ladder& ladder) {
        for (size_t p = 0; p < poses.size() && !garments_.empty(); ++p) {
            const std::vector<Vec3f> corrected = drawer_.pose(poses[p]), plain = drawer_.pose(poses[p], false);
            for (size_t i = 0; i < garments_.size(); ++i) {
                const GarmentPair& garment = garments_[i];
                GarmentCell& cell = ladder.garments[i * poses.size() + p].cells[group];
                const auto distanceMm = [&](const std::vector<Vec3f>& ours) {
                    return 1000 * garmentDistanceM(garment, ours, surface, jobs_);
                };
                cell.correctedMm += distanceMm(corrected), cell.plainMm += distanceMm(plain), ++cell.frames;
                const std::vector<Vec3f> places = places_[i].at(surface);
                const auto pointMm = [&](const std::vector<Vec3f>& ours) {
                    return 1000 * pointDistanceM(garment, in_.avatar.mesh.restPositions, ours, places);
                };
                cell.pointCorrectedMm += pointMm(corrected), cell.pointPlainMm += pointMm(plain);
            }
        }
    }

    const LadderInput& in_;
    const TrueMesh truth_;
    Jobs& jobs_;
    Drawer drawer_;
    std::vector<Triangle> shown_;  // of the true mesh: those that the pictures show
    std::vector<GarmentPair> garments_;
    std::vector<GarmentPlaces> places_;  // one a garment
    LabelColours labels_;
    VertexColours meshColours_;
    std::vector<glm::u8vec4> colours_;
    std::optional<CarriedPoints> whole_, body_;  // the avatar's vertices on the visible true surface, and on the true body
    std::vector<float> weights_;                 // V, of the pose fit
};

}  // namespace

Result<std::optional<Ladder>> measureLadder(const LadderInput& input, Jobs& jobs) {
    if (input.poses.frames.size() != input.scan.frames.size() || input.cameras.size() != input.scan.frames.size())
        return fail(Code::InvalidArgument, "{} poses and {} cameras for {} frames; give the poses.json of this scan",
                    input.poses.frames.size(), input.cameras.size(), input.scan.frames.size());
    DPL_TRY(auto truth, readTrueMesh(input.scan));
    if (!truth) return std::optional<Ladder>();
    return LadderRun(input, std::move(*truth), jobs).run();
}

}  // namespace dpl
