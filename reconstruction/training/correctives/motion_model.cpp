// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/correctives/motion_model.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <string_view>

#include "sdk/avatar/motion_state.h"

namespace dpl {
namespace {

using Bones = std::array<std::string_view, 5>;
constexpr std::array<Bones, 2> kLimbs{{{"spine", "leftUpperLeg", "rightUpperLeg", "leftLowerLeg", "rightLowerLeg"},
                                       {"spine", "leftUpperArm", "rightUpperArm", "leftLowerArm", "rightLowerArm"}}};
constexpr double kLeastFollowing = 0.01;  // share of a layer's skin weights that follows a group's limbs

bool isOneOf(const std::string& bone, const Bones& bones) {
    return std::find(bones.begin(), bones.end(), bone) != bones.end();
}

/** The rotation nearest to all of `poses` at a joint: their normalised sum, with signs as the first one. */
Vec4f meanRotation(std::span<const Pose> poses, uint32_t joint) {
    Vec4d sum(0), first(0);
    for (const Pose& pose : poses) {
        const Quatd q = glm::normalize(Quatd(pose.localRotations[joint]));
        const Vec4d v(q.x, q.y, q.z, q.w);
        if (first == Vec4d(0)) first = v;
        sum += glm::dot(first, v) < 0 ? -v : v;
    }
    return glm::length(sum) > 1e-3 ? Vec4f(glm::normalize(sum)) : Vec4f(0, 0, 0, 1);
}

/** Angles of the joints in the settled state, without limits. */
std::vector<double> settledAngles(MotionModeData motion, const Pose& pose) {
    std::fill(motion.rangeRad.begin(), motion.rangeRad.end(), Vec2f(0, 3.2f));
    motion.holdsS = {0.0f}, motion.lagsS = {};
    const MotionState state = stateOf(motion, pose);
    return {state.held.begin() + 1, state.held.begin() + ptrdiff_t(motion.inputCount())};
}

double lengthOf(const std::vector<double>& v) {
    double squares = 0;
    for (const double x : v) squares += x * x;
    return std::sqrt(squares);
}

/** Sets the angles and the distance within which the subject stands still, and the largest inputs of the motion. */
void setRanges(std::span<const Pose> stillPoses, std::span<const Pose> movingPoses, const MotionModelSettings& settings,
               MotionModeData& motion) {
    std::vector<double> stray(motion.joints.size(), 0.0), largest(motion.joints.size(), 0.0);
    double strayed = 0;
    for (const Pose& pose : stillPoses) {
        const std::vector<double> angles = settledAngles(motion, pose);
        for (size_t j = 0; j < angles.size(); ++j) stray[j] = std::max(stray[j], angles[j]);
        strayed = std::max(strayed, lengthOf(angles));
    }
    for (const Pose& pose : movingPoses) {
        const std::vector<double> angles = settledAngles(motion, pose);
        for (size_t j = 0; j < angles.size(); ++j) largest[j] = std::max(largest[j], angles[j]);
    }
    for (size_t j = 0; j < stray.size(); ++j) {
        const double rest = std::min(std::max(settings.leastRestRad, settings.strayFactor * stray[j]), 3.1);
        motion.rangeRad[j] = Vec2f(float(rest), float(std::max(0.0, largest[j] - rest)));
    }
    motion.movedFromRad = float(std::min(std::max(settings.leastMovedRad, settings.strayFactor * strayed), 6.0));
    motion.movedToRad = motion.movedFromRad + float(settings.movedBandRad);
}

void addColumn(const Eigen::VectorXd& mode, MotionModeData& motion) {
    for (const double x : mode) motion.modes.push_back(float(x));
    ++motion.groups.back().columnCount;
}

/** Adds the principal components of some features of `samples`, states that have moved, as a group. counts: a flag for each feature. What
 * is held loses its mean times "has moved", so that it is 0 in the still pose and centred in motion; lags are 0 at rest anyway. */
void addComponents(const std::vector<uint8_t>& counts, std::span<const MotionState> samples, const MotionModelSettings& settings,
                   MotionModeData& motion) {
    const size_t all = motion.featureCount();
    Eigen::MatrixXd features(Eigen::Index(samples.size()), Eigen::Index(all));
    std::vector<double> row(all);
    for (size_t r = 0; r < samples.size(); ++r) {
        motionFeatures(motion, samples[r], row);
        for (size_t i = 0; i < all; ++i) features(Eigen::Index(r), Eigen::Index(i)) = counts[i] ? row[i] : 0;
    }
    Eigen::RowVectorXd mean = features.colwise().mean();
    mean.tail(Eigen::Index(motion.lagCount())).setZero();
    features.rowwise() -= mean;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(features.transpose() * features / double(samples.size()));
    if (solver.info() != Eigen::Success) return;
    const Eigen::VectorXd& variance = solver.eigenvalues();  // ascending
    motion.groups.emplace_back();
    std::vector<double> squares(samples.size(), 0.0);  // of each sample's components
    for (Eigen::Index c = Eigen::Index(all) - 1; c >= 0 && motion.groups.back().columnCount < settings.maxComponents; --c) {
        if (!(variance(c) > 1e-6) || variance(c) < settings.minVariance * variance.sum()) break;
        Eigen::VectorXd mode = solver.eigenvectors().col(c) / std::sqrt(variance(c));
        Eigen::Index largest = 0;
        mode.cwiseAbs().maxCoeff(&largest);
        if (mode(largest) < 0) mode = -mode;  // an eigenvector's sign is arbitrary
        for (Eigen::Index i = 0; i < mode.size(); ++i)
            if (!counts[size_t(i)]) mode(i) = 0;
        const Eigen::VectorXd k = features * mode;
        for (size_t r = 0; r < squares.size(); ++r) squares[r] += k(Eigen::Index(r)) * k(Eigen::Index(r));
        mode(Eigen::Index(hasMoved(motion))) -= mean.dot(mode);
        addColumn(mode, motion);
    }
    if (motion.groups.back().columnCount == 0) return motion.groups.pop_back();
    motion.groups.back().reach = float(std::sqrt(*std::max_element(squares.begin(), squares.end())));
}

/** The place in MotionModeData::joints of the joint that a feature tells of; none for "has moved". */
std::optional<size_t> jointOfFeature(const MotionModeData& motion, size_t feature) {
    if (feature >= motion.heldCount()) return (feature - motion.heldCount()) % motion.turnCount() / 6;
    const size_t input = feature % motion.inputCount();
    return input > 0 ? std::optional(input - 1) : std::nullopt;
}

enum class Features { Angles, Peaks, Lags };  // of the pose itself (the first hold); held by the other holds; what lags

/** Flags of features: those of a kind that tell of some bones. */
std::vector<uint8_t> featuresOf(Features kind, const MotionModeData& motion, std::span<const JointData> joints, const Bones& bones) {
    const size_t angles = motion.inputCount(), held = motion.heldCount();
    const size_t first = kind == Features::Angles ? 0 : kind == Features::Peaks ? angles : held;
    const size_t end = kind == Features::Angles ? angles : kind == Features::Peaks ? held : motion.featureCount();
    std::vector<uint8_t> counts(motion.featureCount(), 0);
    for (size_t i = first; i < end; ++i)
        if (const auto joint = jointOfFeature(motion, i)) counts[i] = isOneOf(joints[motion.joints[*joint]].humanoidBone, bones);
    return counts;
}

/** The range of a group's columns in MotionModeData::modes. */
std::pair<size_t, size_t> modesOf(const MotionModeData& motion, size_t group) {
    size_t first = 0;
    for (size_t g = 0; g < group; ++g) first += motion.groups[g].columnCount;
    const size_t row = motion.featureCount();
    return {first * row, (first + motion.groups[group].columnCount) * row};
}

/** The joints of a group's columns, as flags of MotionModeData::joints. */
std::vector<uint8_t> heardJoints(const MotionModeData& motion, size_t group) {
    const auto [first, end] = modesOf(motion, group);
    std::vector<uint8_t> heard(motion.joints.size(), 0);
    for (size_t i = first; i < end; ++i)
        if (const auto joint = jointOfFeature(motion, i % motion.featureCount()); joint && motion.modes[i] != 0) heard[*joint] = 1;
    return heard;
}

/** Whether times tell in which order the pictures of a film came. */
bool knowsOrder(std::span<const double> timesS) {
    return !timesS.empty() && std::ranges::min(timesS) < std::ranges::max(timesS);
}

/** Whether a film shows enough pictures a second to tell lags. */
bool isDense(std::span<const double> timesS, double perSecond) {
    std::vector<double> sorted(timesS.begin(), timesS.end()), gaps;
    std::ranges::sort(sorted);
    for (size_t i = 1; i < sorted.size(); ++i) gaps.push_back(sorted[i] - sorted[i - 1]);
    if (gaps.empty()) return false;
    std::ranges::nth_element(gaps, gaps.begin() + ptrdiff_t(gaps.size() / 2));
    const double median = gaps[gaps.size() / 2];
    return median > 0 && median <= 1 / perSecond;
}

}  // namespace

bool isOfPeaks(const MotionModeData& motion, size_t group) {
    const auto [first, end] = modesOf(motion, group);
    for (size_t i = first; i < end; ++i)
        if (const size_t feature = i % motion.featureCount();
            motion.modes[i] != 0 && feature >= motion.inputCount() && feature < motion.heldCount() && jointOfFeature(motion, feature))
            return true;
    return false;
}

size_t hasMoved(const MotionModeData& motion) {
    return (motion.holdsS.size() - 1) * motion.inputCount();
}

void rememberFilm(const MotionModeData& motion, std::span<const double> timesS, std::span<Pose> poses) {
    for (Pose& pose : poses) pose.before = {};
    if (!knowsOrder(timesS)) return;
    std::vector<size_t> order(poses.size());
    std::iota(order.begin(), order.end(), size_t(0));
    std::ranges::stable_sort(order, {}, [&](size_t i) { return timesS[i]; });
    for (size_t k = 1; k < order.size(); ++k)
        poses[order[k]].before = forgetMotion(motion, stateOf(motion, poses[order[k - 1]]), timesS[order[k]] - timesS[order[k - 1]]);
}

Result<MotionModeData> motionModel(std::span<const JointData> joints, std::span<const Pose> stillPoses, std::span<const Pose> movingPoses,
                                   std::span<const double> timesS, const MotionModelSettings& settings) {
    MotionModeData motion;
    if (timesS.size() != movingPoses.size())
        return fail(Code::InvalidArgument, "{} moving poses at {} times", movingPoses.size(), timesS.size());
    for (uint32_t j = 0; j < joints.size(); ++j)
        if (std::any_of(kLimbs.begin(), kLimbs.end(), [&](const Bones& bones) { return isOneOf(joints[j].humanoidBone, bones); }))
            motion.joints.push_back(j);
    if (motion.joints.empty() || stillPoses.empty() || movingPoses.size() < settings.minPoses) return MotionModeData{};
    for (const std::span<const Pose> poses : {stillPoses, movingPoses})
        for (const Pose& pose : poses) DPL_RETURN_IF_ERROR(checkPose(joints, pose));
    for (const uint32_t joint : motion.joints) motion.still.push_back(meanRotation(stillPoses, joint));
    motion.rangeRad.resize(motion.joints.size());
    motion.holdsS = settings.holdsS;
    if (!knowsOrder(timesS)) motion.holdsS.resize(1);  // nothing would be held, so all holds would tell the same
    if (isDense(timesS, settings.lagPosesPerS)) motion.lagsS = settings.lagsS;
    setRanges(stillPoses, movingPoses, settings, motion);
    std::vector<Pose> film(movingPoses.begin(), movingPoses.end());
    rememberFilm(motion, timesS, film);
    std::vector<MotionState> moved;
    for (const Pose& pose : film)
        if (const MotionState state = stateOf(motion, pose); state.held[hasMoved(motion)] > 0.5) moved.push_back(state);
    if (moved.size() < 2 || double(moved.size()) < settings.minMovedShare * double(movingPoses.size())) return MotionModeData{};
    motion.groups.emplace_back();
    addColumn(Eigen::VectorXd::Unit(Eigen::Index(motion.featureCount()), Eigen::Index(hasMoved(motion))), motion);
    for (const Features kind : {Features::Angles, Features::Peaks, Features::Lags})
        for (const Bones& bones : kLimbs) addComponents(featuresOf(kind, motion, joints, bones), moved, settings, motion);
    return motion;
}

std::vector<uint32_t> motionReachingNodes(std::span<const JointData> joints, const MeshData& mesh, const PoseCorrectiveData& c) {
    const MotionModeData& motion = c.motion;
    std::vector<uint32_t> groupsOfJoint(joints.size(), 0), groupsOfNode(c.nodeCount, 0);
    for (size_t g = 1; g < motion.groups.size(); ++g) {
        const std::vector<uint8_t> heard = heardJoints(motion, g);
        for (size_t j = 0; j < heard.size(); ++j)
            if (heard[j] && joints[motion.joints[j]].humanoidBone != "spine") groupsOfJoint[motion.joints[j]] |= 1u << g;
    }
    for (size_t j = 0; j < joints.size(); ++j)
        if (joints[j].parent >= 0) groupsOfJoint[j] |= groupsOfJoint[size_t(joints[j].parent)];
    for (const LayerData& layer : mesh.layers) {
        if (layer.role != "garment" || layer.name == "shoes") continue;
        std::vector<double> following(motion.groups.size(), 0.0);
        for (uint32_t v = layer.firstVertex; v < layer.firstVertex + layer.vertexCount; ++v)
            for (int i = 0; i < 4; ++i)
                for (size_t g = 1; g < following.size(); ++g)
                    if (groupsOfJoint[mesh.jointIndices[v][i]] >> g & 1) following[g] += double(mesh.jointWeights[v][i]) / 255;
        uint32_t groups = 1;
        for (size_t g = 1; g < following.size(); ++g)
            if (following[g] > kLeastFollowing * double(layer.vertexCount)) groups |= 1u << g;
        for (uint32_t v = layer.firstVertex; v < layer.firstVertex + layer.vertexCount; ++v)
            for (int i = 0; i < 4; ++i)
                if (c.nodeWeights[v][i] != 0) groupsOfNode[c.nodeIndices[v][i]] |= groups;
    }
    return groupsOfNode;
}

}  // namespace dpl
