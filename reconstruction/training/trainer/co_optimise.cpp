// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/co_optimise.h"
#include "reconstruction/training/trainer/priors.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "reconstruction/training/trainer/co_optimise_state.h"
#include "reconstruction/training/trainer/pose_step.h"
#include "reconstruction/training/trainer/random.h"
#include "reconstruction/training/trainer/seen_backs.h"
#include "reconstruction/training/trainer/still_vertices.h"
#include "sdk/core/evenly_spaced.h"
#include "sdk/core/task.h"
#include "sdk/format/avatar_file.h"
#include "sdk/format/check_mesh.h"

namespace dpl {
namespace {

enum Stream : uint64_t { kOrderStream = 10, kBackgroundStream = 11 };

double millisecondsSince(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

/** Floats in a node's Adam row: four for each column, padded to a multiple of eight. */
uint32_t nodeStride(const PoseCorrectiveData& c) {
    return (c.columnCount() * 4 + 7) / 8 * 8;
}

bool finite(const Vec3f& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

constexpr size_t kMovingPoses = 8;

/** The poses in which backs of cloth may show: those of stress, the first that is not of a moving frame, and some of the moving ones. */
std::vector<Pose> posesThatShowBacks(const CoOptimiseInput& input) {
    std::vector<Pose> poses = input.stress;
    const auto still =
        std::find_if(input.frames.begin(), input.frames.end(), [](const TrainFrame& f) { return f.kind != FrameKind::Dynamic; });
    if (still != input.frames.end()) poses.push_back(still->pose);
    for (const Pose& pose : evenlySpaced(movingPoses(input.frames), kMovingPoses)) poses.push_back(pose);
    return poses;
}

}  // namespace

CoOptimiseInput inputOf(const AvatarData& avatar, std::vector<uint8_t> triangleLabel, std::vector<TrainFrame> frames) {
    CoOptimiseInput input;
    input.joints = avatar.joints, input.mesh = avatar.mesh, input.correctives = avatar.correctives, input.light = avatar.light;
    input.triangleLabel = std::move(triangleLabel), input.frames = std::move(frames);
    return input;
}

Status CoOptimiser::State::prepare() {
    const MeshData& m = input.mesh;
    const size_t vertexCount = m.restPositions.size();
    if (vertexCount == 0 || m.triangles.empty()) return fail(Code::InvalidArgument, "the template mesh is empty");
    DPL_RETURN_IF_ERROR(checkMesh(m, input.joints.size()));
    DPL_RETURN_IF_ERROR(checkFinite(m));
    if (!input.triangleLabel.empty() && input.triangleLabel.size() != m.triangles.size())
        return fail(Code::InvalidArgument, "{} triangle labels for {} triangles", input.triangleLabel.size(), m.triangles.size());
    if (settings.steps == 0) return fail(Code::InvalidArgument, "a training run needs at least one step");
    if (settings.init.shDegree > kMaxShDegree)
        return fail(Code::InvalidArgument, "SH degree {} is above {}", settings.init.shDegree, kMaxShDegree);
    if (settings.levelStarts.empty() || settings.geometryEvery == 0)
        return fail(Code::InvalidArgument, "the schedule needs a level and geometryEvery of at least 1");
    EngineRoom room{.splats = std::max(settings.maxSplats, settings.init.splatCount),
                    .triangles = uint32_t(m.triangles.size()),
                    .vertices = uint32_t(vertexCount),
                    .shDegree = settings.init.shDegree};
    for (uint32_t i = 0; i < input.frames.size(); ++i) {
        const TrainFrame& f = input.frames[i];
        DPL_TRY(const auto picture, checkedPicture(f));
        hashPicture(*picture);
        if (auto status = checkPose(input.joints, f.pose); !status)
            return fail(status.error().code, "frame '{}': {}", f.name, status.error().message);
        DPL_RETURN_IF_ERROR(checkPrecision(f, input.joints.size()));
        learned.frames.push_back({.pose = f.pose});
        AdamVector& adam = learned.frames.back().adamPose;
        adam.first.assign(f.precision ? f.precision->size() : 3 * input.joints.size() + 3, 0.0);
        adam.second = adam.first;
        const uint64_t pixels = cropPx(*picture);
        if (pixels > 0) usedFrames.push_back(i);
        room.picturePx = std::max(room.picturePx, pixels);
    }
    if (usedFrames.empty())
        return fail(Code::InvalidArgument, "none of the {} training frames has a person in its mask", input.frames.size());
    if (engine) DPL_RETURN_IF_ERROR(engine->begin(room));
    onlyMoving = std::all_of(usedFrames.begin(), usedFrames.end(), [&](uint32_t i) { return input.frames[i].kind == FrameKind::Dynamic; });
    bind = restTriangles(m);
    for (const Triangle& t : m.triangles) {
        const Vec3f e1 = m.restPositions[t.y] - m.restPositions[t.x], e2 = m.restPositions[t.z] - m.restPositions[t.x];
        const float base = std::max(1e-6f, glm::length(e1));
        referenceSizeM.push_back(std::max(0.008f, 0.5f * (base + glm::length(glm::cross(e1, e2)) / base)));
    }
    DPL_RETURN_IF_ERROR(checkCorrectives(input.correctives, input.joints.size(), vertexCount));
    for (const Pose& pose : input.stress) DPL_RETURN_IF_ERROR(checkPose(input.joints, pose));
    learned.layer.correctives = input.correctives;
    incidence = VertexIncidence(m.triangles, vertexCount);
    meshRegulariser.emplace(m.restPositions, m.triangles);
    collision.emplace(m);
    mesh = m;
    if (!input.light.empty()) {
        restNormals.emplace(m);
        restNormals->compute(mesh.restPositions, mesh.triangles, normals);
    }
    if (settings.learnGeometry) {
        DPL_TRY(LargeSteps factor, LargeSteps::create(m.restPositions, m.triangles, settings.smoothingLengthM));
        largeSteps.emplace(std::move(factor));
        learned.layer.u.assign(largeSteps->size(), Vec3f(0));
        learned.layer.restGradientSum.assign(vertexCount, Vec3f(0));
    }
    return {};
}

Result<std::unique_ptr<CoOptimiser>> CoOptimiser::create(CoOptimiseInput input, const CoOptimiseSettings& settings, Jobs& jobs,
                                                         TrainingEngine* engine) {
    auto state = std::make_unique<State>(std::move(input), settings, jobs, engine);
    DPL_RETURN_IF_ERROR(state->prepare());
    State& s = *state;
    const SeenMesh seen{s.input.joints, s.mesh, s.input.triangleLabel, s.input.frames};
    DPL_TRY(const TriangleSight sight, triangleSight(seen, jobs));
    const std::vector<uint8_t> backs = seenBacks(s.input.joints, s.mesh, posesThatShowBacks(s.input), jobs);
    const std::vector<uint8_t> flags = triangleFlags(s.mesh.restPositions, s.mesh.triangles, s.input.triangleLabel, backs, s.settings.init);
    DPL_TRY(TrainableSplats first, initialSplats(seen, flags, sight, s.settings.init, s.settings.seed, jobs));
    holdBareVertices(s.mesh, first, s.learned.layer.correctives);
    s.chooseLearners(sight.seen);
    s.start(std::move(first));
    return std::unique_ptr<CoOptimiser>(new CoOptimiser(std::move(state)));
}

Result<std::unique_ptr<CoOptimiser>> CoOptimiser::createFrom(CoOptimiseInput input, const SplatData& splats,
                                                             const CoOptimiseSettings& settings, Jobs& jobs, TrainingEngine* engine) {
    auto state = std::make_unique<State>(std::move(input), settings, jobs, engine);
    DPL_RETURN_IF_ERROR(state->prepare());
    State& s = *state;
    const size_t n = splats.count();
    if (splats.triangleStart.size() != s.mesh.triangles.size() + 1 || splats.triangleStart.back() != n || splats.phi.size() != n ||
        splats.scaleM.size() != n || splats.opacity.size() != n || splats.flags.size() != n ||
        splats.sh.size() != n * shCoefficientCount(splats.shDegree) * 3)
        return fail(Code::InvalidArgument, "the splats do not fit the mesh of {} triangles", s.mesh.triangles.size());
    const SeenMesh seen{s.input.joints, s.mesh, s.input.triangleLabel, s.input.frames};
    DPL_TRY(const TriangleSight sight, triangleSight(seen, jobs));
    TrainableSplats first = TrainableSplats::fromSplatData(splats, sight.sizeFloorM);
    first.activateAll(jobs);
    s.chooseLearners(sight.seen);
    s.start(std::move(first));
    return std::unique_ptr<CoOptimiser>(new CoOptimiser(std::move(state)));
}

void CoOptimiser::State::chooseLearners(const std::vector<uint8_t>& seen) {
    learns = seen;
    if (!mesh.layers.empty()) std::fill(learns.begin() + mesh.layers.front().triangleCount, learns.end(), uint8_t(1));
}

void CoOptimiser::State::start(TrainableSplats splats) {
    LearnedLayer& layer = learned.layer;
    layer.splats = std::move(splats);
    layer.adam.resize(layer.splats.count(), layer.splats.stride);
    layer.statistics.resize(layer.splats.count());
    if (layer.correctives.empty()) return;
    layer.adamNodes.resize(layer.correctives.nodeCount, nodeStride(layer.correctives));
    if (!layer.correctives.motion.empty()) motionBounds.emplace(input.joints, mesh, layer.correctives);
}

CoOptimiser::CoOptimiser(std::unique_ptr<State> state) : state_(std::move(state)) {}
CoOptimiser::~CoOptimiser() = default;
bool CoOptimiser::finished() const {
    return state_->learned.step >= state_->settings.steps;
}
uint32_t CoOptimiser::step() const {
    return state_->learned.step;
}

float CoOptimiser::State::decay(float end) const {
    return std::pow(end, float(learned.step) / float(settings.steps));
}

Status CoOptimiser::State::selectLevel() {
    const float at = float(learned.step) / float(settings.steps);
    const int last = int(settings.levelStarts.size()) - 1;
    int index = last;
    if (!settings.fullResolutionOnly)
        while (index > 0 && settings.levelStarts[size_t(index)] > at) --index;
    return levels.select(index, last, usedFrames);
}

/** The frame of a step. An epoch visits every frame once, in an order that depends on (seed, epoch) only. */
uint32_t CoOptimiser::State::frameOf(uint32_t atStep) {
    const uint64_t epoch = atStep / usedFrames.size();
    if (epoch != orderEpoch) {
        orderEpoch = epoch;
        order = usedFrames;
        for (size_t i = order.size(); i > 1; --i)
            std::swap(order[i - 1], order[hashBits(settings.seed, kOrderStream + (epoch << 8), i) % i]);
    }
    return order[atStep % usedFrames.size()];
}

void CoOptimiser::State::startProfile() {
    pass.clock.times = {}, profile = {}, counts = true;
}

Status CoOptimiser::State::stepOnce() {
    const auto start = std::chrono::steady_clock::now();
    StepClock& clock = pass.clock;
    LearnedLayer& layer = learned.layer;
    LossSums& sums = learned.sums;
    uint32_t& step = learned.step;
    const auto lastEpoch = uint32_t(std::min<size_t>(settings.steps, usedFrames.size()));
    if (step + lastEpoch == settings.steps) startProfile();
    clock.start();
    DPL_RETURN_IF_ERROR(selectLevel());
    const uint32_t frame = frameOf(step);
    DPL_TRY(const LevelFrame* level, levels.at(frame));
    clock.lap(StepPart::Picture);
    const TrainFrame& f = input.frames[frame];
    LossWeights weights = settings.loss;
    if (!settings.fullResolutionOnly && step < settings.steps / 4) weights.mask *= settings.earlyMaskFactor;
    const uint64_t at = uint64_t(step) * 3;
    const Vec3f background(float(hashUniform(settings.seed, kBackgroundStream, at)),
                           float(hashUniform(settings.seed, kBackgroundStream, at + 1)),
                           float(hashUniform(settings.seed, kBackgroundStream, at + 2)));
    const bool geometry = settings.learnGeometry || settings.learnPoses || learnsCorrectives();
    DPL_TRY(const LossValues loss, passOf(frame, *level, weights, background));
    if (!std::isfinite(loss.total)) return fail(Code::Internal, "training step {} (frame '{}'): the loss is not finite", step, f.name);

    clock.start();
    if (geometry) pullGarments();
    clock.lap(StepPart::Collision);
    updateAll(frame, *level, loss.total);
    sums.loss += loss.total, sums.l1 += loss.l1, sums.ssim += loss.ssim, sums.mask += loss.mask, ++sums.steps;
    sums.squaredError += loss.squaredError, sums.squaredCount += loss.squaredCount;
    ++step;
    if (settings.densify && settings.densityEvents > 0) {
        const uint32_t first = uint32_t(0.08 * settings.steps), last = uint32_t(0.55 * settings.steps),
                       every = std::max(1u, (last - first) / settings.densityEvents);
        if (step > first && step <= last && (step - first) % every == 0) {
            DensitySettings d;
            d.seed = settings.seed, d.maxSplats = settings.maxSplats;
            const uint32_t start0 = settings.init.splatCount;
            d.maxGrowth = std::max(500u, settings.maxSplats > start0 ? 2 * (settings.maxSplats - start0) / settings.densityEvents : 500u);
            DPL_RETURN_IF_ERROR(bringBack());
            densify(layer.splats, layer.adam, layer.statistics, bind, referenceSizeM, d, (step - first) / every);
            engineCurrent = false;
        }
    }
    if (sums.steps >= std::max<uint32_t>(1, std::min<uint32_t>(100, settings.steps / 20)) || step == settings.steps) {
        learned.curve.push_back(recentPoint());
        sums = {};
    }
    clock.lap(StepPart::Density);
    profile.stepMs += millisecondsSince(start), ++profile.steps;
    if (counts && !engine) {  // the time of counting is not in stepMs
        const SplatImage& image = pass.image();
        profile.pairs += double(countPixelSplatPairs(pass.engine(), image.widthPx, image.heightPx));
        profile.entries += pass.engine().tiles().offset.back(), profile.visible += pass.engine().visibleCount();
        profile.pixels += double(image.widthPx) * image.heightPx;
    }
    return {};
}

Result<LossValues> CoOptimiser::State::passOf(uint32_t frame, const LevelFrame& level, const LossWeights& weights,
                                              const Vec3f& background) {
    LearnedLayer& layer = learned.layer;
    const PassSubject subject{layer.splats, mesh, layer.correctives, input.joints, {bind, restNow}, incidence, input.light, normals};
    const bool geometry = settings.learnGeometry || settings.learnPoses || learnsCorrectives();
    const Pose& pose = learned.frames[frame].pose;
    if (!engine) return pass.run(subject, pose, level, weights, background, geometry);
    if (engineLost) return *engineLost;
    const auto lose = [this](const Error& error) {
        engineLost = error;
        return error;
    };
    if (!engineCurrent) {
        const EngineState state{layer.splats, layer.adam, layer.statistics, learns, referenceSizeM, incidence, mesh.triangles, bind};
        if (Status taken = engine->upload(state); !taken) return lose(taken.error());
        engineCurrent = true, engineRest = restNow.empty();
    }
    if (!engineRest)
        if (Status taken = engine->setRest(restNow); !taken) return lose(taken.error());
    engineRest = true;
    const SplatUpdate update = splatUpdate(frame, level);
    const auto loss = pass.run(subject, pose, level, weights, background, *engine, settings.learnSplats ? &update : nullptr);
    if (!loss) return lose(loss.error());
    engineAhead |= settings.learnSplats;
    return *loss;
}

Status CoOptimiser::State::bringBack() {
    if (engineLost) return *engineLost;
    if (!engineAhead) return {};
    LearnedLayer& layer = learned.layer;
    if (Status back = engine->download(layer.splats, layer.adam, layer.statistics); !back) {
        engineLost = back.error();
        return back;
    }
    engineAhead = false;
    return {};
}

void CoOptimiser::State::updateAll(uint32_t frame, const LevelFrame& level, double loss) {
    constexpr size_t kAlone = 3, kGrain = 2048;  // updates that one thread computes; splats a block
    const SplatUpdate update = splatUpdate(frame, level);
    const uint32_t count = settings.learnSplats && !engine ? learned.layer.splats.count() : 0;
    double aloneMs[kAlone] = {};
    bool moved = false;
    jobs.forBlocks(kAlone + (count + kGrain - 1) / kGrain, [&](size_t block, uint32_t) {
        if (block >= kAlone) {
            const size_t begin = (block - kAlone) * kGrain;
            updateSplats(update, begin, std::min<size_t>(count, begin + kGrain));
            return;
        }
        const double before = StepClock::now().caller;
        if (block == 0 && settings.learnGeometry) moved = updateOffsets();
        if (block == 1 && learnsCorrectives()) updateCorrectives();
        if (block == 2 && settings.learnPoses) updatePose(frame, level, loss);
        aloneMs[block] = StepClock::now().caller - before;
    });
    pass.clock.lap(StepPart::Adam);
    constexpr StepPart kParts[kAlone] = {StepPart::Offsets, StepPart::Nodes, StepPart::PoseStep};
    for (size_t k = 0; k < kAlone; ++k) pass.clock.move(StepPart::Adam, kParts[k], aloneMs[k]);
    if (moved) restTriangles(mesh, jobs, restNow), engineRest = false;
    pass.clock.lap(StepPart::Offsets);
}

SplatUpdate CoOptimiser::State::splatUpdate(uint32_t frame, const LevelFrame& level) {
    const TrainableSplats& splats = learned.layer.splats;
    SplatUpdate update;
    update.regularise = settings.regularise;
    update.counts = input.frames[frame].kind != FrameKind::Dynamic || onlyMoving;
    update.halfHeight = 0.5f * float(level.camera.fy) / float(input.frames[frame].camera.fy) * float(input.frames[frame].camera.heightPx);
    std::vector<float>& rate = update.rate;
    rate.assign(splats.stride, 0.0f);
    const float colour = decay(settings.endColour);
    if (settings.learnPlacement) {
        rate[kRowU] = rate[kRowV] = settings.rateUv * decay(settings.endUv);
        rate[kRowPhi] = settings.ratePhi * decay(settings.endLogScale);
    }
    rate[kRowLogScale1] = rate[kRowLogScale2] = settings.rateLogScale * decay(settings.endLogScale);
    rate[kRowOpacityLogit] = settings.rateOpacity * decay(settings.endOpacity);
    for (uint32_t k = 0; k < shCoefficientCount(splats.shDegree) * 3; ++k)
        rate[kRowSh + k] = (k < 3 ? settings.rateDc : settings.rateRest) * colour;
    if (input.frames[frame].kind == FrameKind::StaticCloseup)
        for (float& r : rate) r *= settings.closeupStepScale;
    return update;
}

void CoOptimiser::State::updateSplats(const SplatUpdate& update, size_t begin, size_t end) {
    SplatBackward& b = pass.splatBackward();
    TrainableSplats& splats = learned.layer.splats;
    DensityStatistics& statistics = learned.layer.statistics;
    const auto rows = b.rowGradients();
    const auto length = b.screenGradientLength();
    const auto active = b.active();
    for (size_t i = begin; i < end; ++i) active[i] = active[i] && learns[splats.triangle[i]];
    addSplatRegularisers(splats, referenceSizeM, active, update.regularise, begin, end, rows);
    for (size_t i = begin; i < end; ++i) {
        if (!active[i]) continue;
        float* row = rows.data() + i * splats.stride;
        float squares[8] = {};  // Adam keeps them; eight sums, which the compiler keeps in vectors
        for (uint32_t k = 0; k < splats.stride; k += 8)
            for (uint32_t lane = 0; lane < 8; ++lane) squares[lane] += row[k + lane] * row[k + lane];
        if (!std::isfinite(std::accumulate(squares, squares + 8, 0.0f))) {
            std::fill_n(row, splats.stride, 0.0f);
            continue;
        }
        const float screen = length[i] * update.halfHeight;
        if (update.counts && std::isfinite(screen)) statistics.gradientSum[i] += screen, ++statistics.seen[i];
    }
    learned.layer.adam.update(begin, end, active, rows, update.rate, splats.rows);
    splats.activate(begin, end, active);
}

void CoOptimiser::State::updatePose(uint32_t frame, const LevelFrame& level, double loss) {
    LearnedFrame& own = learned.frames[frame];
    const TrainFrame& given = input.frames[frame];
    const double fall = decay(settings.endPose);
    const PosePull pull{given.pose, given.precision.get(), lossPerNat(loss, level.personPx, priors::kTrainedPictureTrust)};
    stepPose(own.pose, own.adamPose, pass.poseGradient(), {settings.rateRotation * fall, settings.rateTranslation * fall}, pull);
}

bool CoOptimiser::State::updateOffsets() {
    LearnedLayer& layer = learned.layer;
    const auto& g = pass.restGradient();
    for (size_t v = 0; v < g.size(); ++v) layer.restGradientSum[v] += g[v];
    for (size_t v = 0; v < collisionGradient.size(); ++v) layer.restGradientSum[v] += collisionGradient[v];
    if (layer.correctives.motion.empty())
        for (size_t v = 0; v < stressGradient.size(); ++v) layer.restGradientSum[v] += stressGradient[v];
    if (++layer.restGradientCount < settings.geometryEvery) return false;
    const float scale = 1.0f / float(layer.restGradientCount);
    bool good = true;
    for (Vec3f& g : layer.restGradientSum) g *= scale, good &= finite(g);
    if (good) {  // M⁻¹ would spread one value that is not finite over the whole mesh
        meshRegulariser->run(mesh.restPositions, settings.regularise, 1.0f, layer.restGradientSum);
        std::vector<Vec3f> uGradient(layer.u.size());
        largeSteps->backward(layer.restGradientSum, uGradient, bodyVertices());
        layer.adamOffsets.update(uGradient, settings.rateOffsets * decay(settings.endOffsets), layer.u);
        moveMesh();
    }
    std::fill(layer.restGradientSum.begin(), layer.restGradientSum.end(), Vec3f(0));
    layer.restGradientCount = 0;
    return good;
}

void CoOptimiser::State::pullGarments() {
    collisionGradient.clear(), stressGradient.clear();
    if (!(settings.regularise.collision > 0) || learned.step % settings.geometryEvery != 0 || collision->empty()) return;
    const auto pull = [&](const PosedMesh& posed, float steps, std::vector<Vec3f>& gradient) {
        collision->pull(mesh, posed, pass.restGradient(), settings.regularise.collision * steps, jobs, gradient);
    };
    const auto every = float(settings.geometryEvery);
    pull(pass.posed(), every, collisionGradient);
    const uint32_t turn = learned.step / settings.geometryEvery;
    if (input.stress.empty() || !settings.learnGeometry || turn % 2 == 0) return;
    stressed.pose({input.joints, mesh, learned.layer.correctives, {bind, restNow}}, input.stress[turn / 2 % input.stress.size()], jobs);
    pull(stressed, 2 * every, stressGradient);
}

void CoOptimiser::State::applyOffsets() {
    if (!largeSteps) return;
    moveMesh();
    restTriangles(mesh, jobs, restNow), engineRest = false;
}

void CoOptimiser::State::moveMesh() {
    std::vector<Vec3f> offsets(mesh.restPositions.size());
    largeSteps->offsets(learned.layer.u, offsets, bodyVertices());
    for (size_t v = 0; v < offsets.size(); ++v) mesh.restPositions[v] = input.mesh.restPositions[v] + offsets[v];
    if (restNormals) restNormals->compute(mesh.restPositions, mesh.triangles, normals);
}

Vec4f CoOptimiser::State::startOf(uint32_t node, uint32_t column) const {
    const PoseCorrectiveData& c = input.correctives;
    return node < c.nodeCount ? c.nodes[size_t(node) * c.columnCount() + column] : Vec4f(0);  // a node for bare vertices came later
}

void CoOptimiser::State::updateCorrectives() {
    PoseCorrectiveData& c = learned.layer.correctives;
    AdamRows& adamNodes = learned.layer.adamNodes;
    const std::span<const float> k = pass.posed().coefficients();
    std::vector<Vec4f> gNodes(pass.nodeGradient().begin(), pass.nodeGradient().end());
    if (!collisionGradient.empty()) {
        std::vector<Vec4f> gCollision;
        const std::vector<float> noLight(collisionGradient.size(), 0.0f);
        gatherNodes(c, pass.posed().nodes(), collisionGradient, noLight, gCollision);
        for (size_t n = 0; n < gNodes.size(); ++n) gNodes[n] += gCollision[n];
    }
    // In a stress pose other correctives have faded, but motion modes act in full. They alone answer for it: the rest shape is the still
    // one.
    std::vector<Vec4f> gStress;
    if (!stressGradient.empty() && !c.motion.empty()) {
        const std::vector<float> noLight(stressGradient.size(), 0.0f);
        gatherNodes(c, stressed.nodes(), stressGradient, noLight, gStress);
    }
    const uint32_t columns = c.columnCount(), stride = adamNodes.stride;
    std::vector<float> rate(stride, 0.0f), values(size_t(c.nodeCount) * stride, 0.0f), gradients(values.size(), 0.0f);
    std::vector<uint8_t> active(c.nodeCount, 0);
    const float fall = decay(settings.endNodes);
    for (uint32_t i = 0; i < columns * 4; ++i) rate[i] = fall * (i % 4 == 3 ? settings.rateNodeLight : settings.rateNodeOffset);
    for (uint32_t n = 0; n < c.nodeCount; ++n) {
        const Vec4f &g = gNodes[n], stress = gStress.empty() ? Vec4f(0) : gStress[n];
        const Vec4f both = g + stress;
        if ((g == Vec4f(0) && stress == Vec4f(0)) || !std::isfinite(both.x + both.y + both.z + both.w)) continue;
        active[n] = 1;
        for (uint32_t i = 0; i < columns; ++i) {
            const Vec4f& value = c.nodes[size_t(n) * columns + i];
            Vec4f gradient = k[i] * g;
            if (i >= c.modeCount && !gStress.empty()) gradient += stressed.coefficients()[i] * stress;
            for (uint32_t a = 0; a < 4; ++a)
                values[n * stride + i * 4 + a] = value[int(a)], gradients[n * stride + i * 4 + a] = gradient[int(a)];
        }
    }
    const float keep = 1 - fall * settings.nodeDecay;  // decay is applied outside Adam, which would rescale the gradient of a penalty
    adamNodes.update(0, c.nodeCount, active, gradients, rate, values);
    for (uint32_t n = 0; n < c.nodeCount; ++n)
        if (active[n])
            for (uint32_t i = 0; i < columns; ++i)
                for (uint32_t a = 0; a < 4; ++a) {
                    const float start = startOf(n, i)[int(a)];
                    c.nodes[size_t(n) * columns + i][int(a)] = start + keep * (values[n * stride + i * 4 + a] - start);
                }
    if (motionBounds) motionBounds->apply(c);
}

CurvePoint CoOptimiser::State::recentPoint() const {
    const LossSums& sums = learned.sums;
    CurvePoint p;
    p.step = learned.step, p.splats = learned.layer.splats.count();
    const double n = std::max(1u, sums.steps);
    p.loss = float(sums.loss / n), p.l1 = float(sums.l1 / n), p.ssim = float(sums.ssim / n), p.mask = float(sums.mask / n);
    p.psnr = sums.squaredError > 0 ? float(-10 * std::log10(sums.squaredError / sums.squaredCount)) : 0;
    return p;
}

std::string CoOptimiser::State::told() const {
    const CurvePoint recent = learned.sums.steps > 0 || learned.curve.empty() ? recentPoint() : learned.curve.back();
    char line[96];
    std::snprintf(line, sizeof line, "step %u of %u, %u splats, scale %.2f, %.1f dB", learned.step, settings.steps,
                  learned.layer.splats.count(), double(levels.scaleOf(usedFrames[0])), double(recent.psnr));
    return line;
}

Status CoOptimiser::run(uint32_t maxSteps) {
    State& s = *state_;
    const Learned& now = s.learned;
    for (uint32_t done = 0; now.step < s.settings.steps && done < maxSteps; ++done) {
        if (Status heard = taskAt(double(now.step) / s.settings.steps, s.told()); !heard) {
            DPL_RETURN_IF_ERROR(s.bringBack());
            return heard;
        }
        DPL_RETURN_IF_ERROR(s.stepOnce());
    }
    return s.bringBack();
}

const std::vector<CurvePoint>& CoOptimiser::curve() const {
    return state_->learned.curve;
}

CoOptimiseResult CoOptimiser::result() const {
    const State& s = *state_;
    CoOptimiseResult r;
    AvatarData avatar;
    avatar.joints = s.input.joints;
    avatar.mesh = s.mesh;
    avatar.splats = s.learned.layer.splats.toSplatData();
    if (s.settings.learnGeometry) (void)rebaseSplats(s.input.mesh.restPositions, avatar);
    r.splats = std::move(avatar.splats);
    r.restPositions = s.mesh.restPositions;
    r.correctives = s.learned.layer.correctives;
    r.light = s.input.light;
    for (const LearnedFrame& frame : s.learned.frames) r.poses.push_back(frame.pose);
    r.curve = s.learned.curve;
    r.framesUsed = uint32_t(s.usedFrames.size());
    r.profile = profile();
    return r;
}

void CoOptimiser::startProfile() {
    state_->startProfile();
}

double CoOptimiser::recentLoss() const {
    return state_->recentPoint().loss;
}
uint32_t CoOptimiser::splatCount() const {
    return state_->learned.layer.splats.count();
}

StepProfile CoOptimiser::profile() const {
    const State& s = *state_;
    StepProfile p = s.profile;
    if (p.steps > 0) {
        const double n = p.steps;
        p.stepMs /= n, p.pairs /= n, p.entries /= n, p.visible /= n, p.pixels /= n;
        p.parts = s.pass.clock.times;
        for (PartTime& t : p.parts) t.wall /= n, t.cpu /= n, t.caller /= n;
        const auto nsPerPair = [&p](StepPart part) { return p.parts[size_t(part)].wall * 1e6 / p.pairs; };
        if (p.pairs > 0) p.forwardNsPerPair = nsPerPair(StepPart::Blend), p.backwardNsPerPair = nsPerPair(StepPart::Pixels);
    }
    return p;
}

}  // namespace dpl
