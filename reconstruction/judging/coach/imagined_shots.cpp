// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/coach/imagined_shots.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "reconstruction/judging/coach/shots.h"
#include "reconstruction/subject/surface/orbit_camera.h"
#include "sdk/core/percentile.h"
#include "sdk/math/skinning.h"

namespace dpl {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr uint32_t kViewsPerCamera = 2;  // a person who films slowly leaves about two pictures a viewpoint
constexpr double kFilled = 0.85;         // share of the picture that the subject of a shot may fill
constexpr double kSmall = 0.6;           // share of the picture's height below which the person is filmed from too far
constexpr double kWalkAroundEffort = 1.8;

struct CloseUpKind {
    const char *key, *name, *from;
    std::vector<BodyPlace> of;
    bool plural;
    double distanceM;
    double azimuthDeg;  // 0: in front, 90: at the person's left; of hands: outwards
    double elevationDeg, spreadDeg;
};
const std::vector<CloseUpKind>& closeUpKinds() {
    using enum BodyPlace;
    static const std::vector<CloseUpKind> kinds = {
        {"face", "the face", "slowly from one ear to the other", {Face}, false, 0.5, 0, 5, 60},
        {"head", "the head from behind", "slowly from one ear to the other", {Head}, false, 0.6, 180, 10, 80},
        {"left_hand", "the left hand", "slowly from all sides", {LeftHand}, false, 0.4, 0, 10, 70},
        {"right_hand", "the right hand", "slowly from all sides", {RightHand}, false, 0.4, 0, 10, 70},
        {"feet", "the feet", "from above, slowly round them", {LeftFoot, RightFoot}, true, 0.6, 0, 35, 80},
        {"chest", "the chest and belly", "slowly from side to side", {Chest}, true, 0.8, 0, 5, 45},
        {"back", "the back", "slowly from side to side", {Back}, false, 0.8, 180, 5, 45},
    };
    return kinds;
}

constexpr std::pair<const char*, const char*> kSectors[] = {
    {"front", "in front of the person, from shoulder to shoulder"},
    {"front left", "past the person's front left"},
    {"left", "past the person's left side"},
    {"back left", "past the person's back left"},
    {"back", "behind the person, from shoulder to shoulder"},
    {"back right", "past the person's back right"},
    {"right", "past the person's right side"},
    {"front right", "past the person's front right"},
};

/** Sums the corners of the triangles of some places. */
struct Middle {
    Vec3d sum{0};
    size_t count = 0;
    void add(const Vec3f& corner) { sum += Vec3d(corner), ++count; }
    Vec3d value() const { return sum / double(count); }
};

/** The person's axes as rows: left, up, front. Up points from the feet to the head, because the trunk leans by 14° in some fits, and the
 *  world's axes say nothing where its up is arbitrary. A body without known feet or head: the axes of its root. */
Mat3d personFromWorld(const Mat3d& worldFromRoot, const std::vector<Vec3f>& positions, std::span<const Triangle> triangles,
                      std::span<const BodyPlace> places) {
    using enum BodyPlace;
    Middle head, feet;
    for (size_t t = 0; t < places.size(); ++t)
        for (int k = 0; k < 3; ++k) {
            if (places[t] == Face || places[t] == Head) head.add(positions[triangles[t][k]]);
            if (places[t] == LeftFoot || places[t] == RightFoot) feet.add(positions[triangles[t][k]]);
        }
    const Vec3d stature = head.count > 0 && feet.count > 0 ? head.value() - feet.value() : worldFromRoot[1];
    const Vec3d front = glm::cross(worldFromRoot[0], stature);
    if (!(glm::length(front) > 1e-3 * glm::length(worldFromRoot[0]))) return glm::transpose(worldFromRoot);  // lies on its side
    const Vec3d up = glm::normalize(stature), forward = glm::normalize(front);
    return glm::transpose(Mat3d(glm::cross(up, forward), up, forward));
}

/** Directions and heights are the person's (personFromWorld); cameras and positions are the world's. */
class Imagination {
public:
    Imagination(const MeshData& surface, std::span<const JointData> joints, std::span<const BodyPlace> places, const PosedPicture& usual)
        : surface_(surface), places_(places), lens_(usual.camera), positions_(surface.restPositions.size()) {
        std::vector<Mat3x4f> worldFromRest;
        jointTransforms(joints, usual.pose, worldFromRest);
        for (size_t v = 0; v < positions_.size(); ++v)
            positions_[v] = skinVertex(surface.restPositions[v], surface.jointIndices[v], surface.jointWeights[v], worldFromRest.data());
        const Mat3d worldFromRoot(worldFromRest[0][0], worldFromRest[0][1], worldFromRest[0][2]);
        personFromWorld_ = personFromWorld(worldFromRoot, positions_, surface.triangles, places);
        low_ = high_ = inPerson(positions_.front());
        for (const Vec3f& p : positions_) low_ = glm::min(low_, inPerson(p)), high_ = glm::max(high_, inPerson(p));
        middle_ = 0.5 * (low_ + high_);
    }

    ImaginedShot closeUp(const CloseUpKind& kind) const {
        std::vector<Vec3d> points;
        for (size_t t = 0; t < places_.size(); ++t)
            if (std::find(kind.of.begin(), kind.of.end(), places_[t]) != kind.of.end())
                for (int k = 0; k < 3; ++k) points.push_back(inPerson(positions_[surface_.triangles[t][k]]));
        ImaginedShot shot;
        if (points.empty()) return shot;
        Vec3d centre(0);
        for (const Vec3d& p : points) centre += p / double(points.size());
        std::vector<double> reaches;
        for (const Vec3d& p : points) reaches.push_back(glm::length(p - centre));
        const double distance = roundedCm(std::max(kind.distanceM, distanceThatShows(2 * percentile(reaches, 0.9), 0)));
        const bool hand = kind.of.front() == BodyPlace::LeftHand || kind.of.front() == BodyPlace::RightHand;
        const double azimuth = hand ? std::atan2(centre.x - middle_.x, centre.z - middle_.z) : kind.azimuthDeg * kDegree;
        shot.key = formatText("closeup {}", kind.key);
        shot.action = formatText("Film {} from {} cm, {}", kind.name, std::round(100 * distance), kind.from);
        shot.of = kind.of, shot.plural = kind.plural;
        for (const double share : {-1.0, -0.5, 0.0, 0.5, 1.0})
            shot.cameras.push_back(at(centre, distance, azimuth + share * kind.spreadDeg * kDegree, kind.elevationDeg * kDegree));
        return shot;
    }

    /** `distanceM`, `elevationRad`: as the person was filmed. */
    std::vector<ImaginedShot> walks(double distanceM, double elevationRad) const {
        const double filling = distanceThatShows(high_.y - low_.y, 1);
        const bool nearer = distanceM > filling * kFilled / kSmall;
        const double distance = nearer ? filling : distanceM;
        const std::string from = nearer ? formatText(" from {} m in place of {} m", metres(distance), metres(distanceM)) : "";
        std::vector<ImaginedShot> shots;
        ImaginedShot around;
        around.key = "walk around", around.action = "Walk round the person again" + from, around.effort = kWalkAroundEffort;
        for (size_t s = 0; s < std::size(kSectors); ++s) {
            const double azimuth = double(s) * 45 * kDegree;
            ImaginedShot shot;
            shot.key = formatText("walk {}", kSectors[s].first);
            shot.action = formatText("Walk once more {}{}", kSectors[s].second, from);
            for (const double share : {-30.0, 0.0, 30.0})
                shot.cameras.push_back(at(middle_, distance, azimuth + share * kDegree, elevationRad));
            around.cameras.push_back(shot.cameras[1]);
            shots.push_back(std::move(shot));
        }
        shots.push_back(std::move(around));
        return shots;
    }

    void look(ImaginedShot& shot) const {
        shot.pixelM.assign(surface_.triangles.size(), 0), shot.views.assign(surface_.triangles.size(), 0);
        for (const Camerad& camera : shot.cameras) {
            const std::vector<Sight> sights = lookAt(positions_, surface_.triangles, camera);
            for (size_t t = 0; t < sights.size(); ++t) {
                const float pixelM = sights[t].pixelM;
                if (!(pixelM > 0)) continue;
                shot.pixelM[t] = shot.pixelM[t] > 0 ? std::min(shot.pixelM[t], pixelM) : pixelM;
                if (sights[t].straight) shot.views[t] += kViewsPerCamera;
            }
        }
    }

    /** From the middle of the person. */
    Vec3d wayTo(const Vec3d& placeInWorld) const { return personFromWorld_ * placeInWorld - middle_; }

private:
    const MeshData& surface_;
    std::span<const BodyPlace> places_;
    Camerad lens_;
    std::vector<Vec3f> positions_;
    Mat3d personFromWorld_{1.0};
    Vec3d low_, high_, middle_;  // in the person's axes

    Vec3d inPerson(const Vec3f& positionInWorld) const { return personFromWorld_ * Vec3d(positionInWorld); }
    static double roundedCm(double m) { return std::ceil(m * 20 - 1e-9) / 20; }
    static std::string metres(double m) { return formatText("{}", std::round(10 * m) / 10); }
    /** At which something of this size fills kFilled of the picture: of its shorter side (0) or of its height (1). */
    double distanceThatShows(double sizeM, int height) const {
        const double tall = lens_.heightPx / lens_.fy, across = lens_.widthPx / lens_.fx;
        return sizeM / (kFilled * (height ? tall : std::min(tall, across)));
    }
    Camerad at(const Vec3d& target, double distanceM, double azimuthRad, double elevationRad) const {
        const double focalPx = 0.5 * (lens_.fx + lens_.fy);
        Camerad camera = orbitCamera(target, distanceM, azimuthRad, elevationRad, focalPx, lens_.widthPx, lens_.heightPx);
        camera.viewFromWorldRotation = camera.viewFromWorldRotation * personFromWorld_;
        return camera;
    }
};

const PosedPicture* firstFullBody(std::span<const PosedPicture> pictures) {
    const auto usual = std::find_if(pictures.begin(), pictures.end(), [](const PosedPicture& p) { return !p.closeUp; });
    return usual == pictures.end() ? nullptr : &*usual;
}

std::optional<Imagination> imagine(const MeshData& surface, std::span<const JointData> joints, std::span<const BodyPlace> places,
                                   std::span<const PosedPicture> pictures) {
    const PosedPicture* usual = firstFullBody(pictures);
    if (!usual || surface.triangles.empty()) return std::nullopt;
    return Imagination(surface, joints, places, *usual);
}

/** All shots with their cameras; nothing looks through those yet. */
std::vector<ImaginedShot> plan(const Imagination& imagination, std::span<const PosedPicture> pictures) {
    std::vector<double> distances, elevations;
    for (const PosedPicture& p : pictures) {
        if (p.closeUp) continue;
        const Vec3d way = imagination.wayTo(p.camera.eye());
        distances.push_back(glm::length(way));
        elevations.push_back(std::asin(std::clamp(way.y / std::max(1e-9, glm::length(way)), -0.9, 0.9)));
    }
    std::vector<ImaginedShot> shots = imagination.walks(percentile(distances, 0.5), percentile(elevations, 0.5));
    for (const CloseUpKind& kind : closeUpKinds())
        if (ImaginedShot shot = imagination.closeUp(kind); !shot.cameras.empty()) shots.push_back(std::move(shot));
    return shots;
}

}  // namespace

double ImaginedShot::typicalPixelM() const {
    std::vector<float> shown;
    for (const float size : pixelM)
        if (size > 0) shown.push_back(size);
    return double(percentile(std::move(shown), 0.5));
}

std::vector<ImaginedShot> imagineShots(const MeshData& surface, std::span<const JointData> joints, std::span<const BodyPlace> places,
                                       std::span<const PosedPicture> pictures, Jobs& jobs) {
    const std::optional<Imagination> imagination = imagine(surface, joints, places, pictures);
    if (!imagination) return {};
    std::vector<ImaginedShot> shots = plan(*imagination, pictures);
    jobs.forBlocks(shots.size(), [&](size_t i, uint32_t) { imagination->look(shots[i]); });
    return shots;
}

std::optional<Camerad> cameraOfShot(std::string_view key, const MeshData& surface, std::span<const JointData> joints,
                                    std::span<const BodyPlace> places, std::span<const PosedPicture> pictures) {
    const std::optional<Imagination> imagination = imagine(surface, joints, places, pictures);
    if (!imagination) return std::nullopt;
    for (const ImaginedShot& shot : plan(*imagination, pictures))
        if (shot.key == key) return shot.cameras[shot.cameras.size() / 2];
    return std::nullopt;
}

}  // namespace dpl
