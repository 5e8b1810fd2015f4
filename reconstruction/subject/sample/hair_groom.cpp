// SPDX-License-Identifier: Apache-2.0
// How locks lie: short ones turn about a whorl and stand up along a parting, long ones fall to both sides of it, behind the face.
#include <algorithm>
#include <cmath>
#include <map>

#include "reconstruction/subject/sample/field.h"
#include "reconstruction/subject/sample/hair_swing.h"
#include "reconstruction/subject/sample/random.h"
#include "reconstruction/subject/sample/skeleton.h"
#include "reconstruction/subject/sample/subject.h"

namespace dpl {
namespace {

constexpr uint64_t kStyleStream = 8410, kLockStream = 8500, kNeighboursStream = 12000;
constexpr double kSettleS = 6;
constexpr Vec3d kDown(0, -1, 0);

double rampd(double x, double from, double to) {
    return double(ramp(float(x), float(from), float(to)));
}

/** What a seed decides for all locks. */
struct Comb {
    Vec3d middle;         // of the skull
    double side = 1;      // −1 or 1: where the parting is, and which way the whorl turns
    double partingM = 0;  // its place, metres to the left
    Vec3d whorl;          // unit, from the middle
    double length = 1;    // factor

    Comb(const Subject& subject, Hairstyle style) : middle(subject.joints[kHead].restPosition + Vec3f(0, 0.098f, -0.010f)) {
        Random random(subject.seed, kStyleStream);
        side = random.below(2) ? 1 : -1;
        partingM = side * random.uniform(0.012, 0.034);
        whorl = glm::normalize(Vec3d(side * random.uniform(0.05, 0.2), 0.80, -random.uniform(0.45, 0.65)));
        length = style == Hairstyle::Long ? random.uniform(0.86, 1.04) : random.uniform(0.9, 1.1);
    }
    Vec3d from(const Vec3d& p) const { return glm::normalize(p - middle); }
};

Vec3d along(const Vec3d& v, const Vec3d& normal) {
    const Vec3d t = v - normal * glm::dot(v, normal);
    return glm::length(t) > 1e-6 ? glm::normalize(t) : Vec3d(0);
}

/** The way that short hair lies at a place on the scalp: unit, along it. */
Vec3d shortFlow(const Comb& comb, const Vec3d& p, const Vec3d& normal) {
    const Vec3d u = comb.from(p), away = along(-comb.whorl, u), round = glm::cross(u, away);
    const double angle = std::acos(std::clamp(glm::dot(u, comb.whorl), -1.0, 1.0));
    const double turn = comb.side * (0.25 + 1.0 * std::exp(-angle / 0.35));
    Vec3d flow = away * std::cos(turn) + round * std::sin(turn);
    // In front it is combed up and over from the parting.
    const double front = rampd(u.z, 0.05, 0.55) * rampd(u.y, 0.2, 0.6);
    const double over = std::tanh((p.x - comb.partingM) / 0.012);
    flow = glm::mix(flow, Vec3d(0.85 * over, 0, 0.35), 0.85 * front);
    return along(flow, normal);
}

/** The way that long hair falls at a place near the head: unit. */
Vec3d longFlow(const Comb& comb, const Vec3d& p) {
    const Vec3d u = comb.from(p);
    const double top = rampd(u.y, 0.15, 0.9), front = rampd(u.z, -0.1, 0.7);
    const double over = std::tanh((p.x - comb.partingM) / 0.010) * rampd(u.z, -0.75, -0.2) + 0.5 * u.x * rampd(u.z, -0.2, -0.75);
    return glm::normalize(kDown + Vec3d(1.1 * top * over, 0, -0.18 - 0.55 * front - 0.35 * top));
}

void keepOut(Vec3d& p, const Vec3d& before, double linkM, double clearanceM, const PosedSolids& solids) {
    for (int i = 0; i < 4; ++i) {
        const auto near = solids.nearest(p);
        if (near.distanceM < clearanceM) p += (clearanceM - near.distanceM) * near.outward;
        p = before + linkM * glm::normalize(p - before);
    }
}

/** Where a lock is rooted, and what chance does to it alone and to its neighbours alike. */
struct Root {
    const Comb& comb;
    const PosedSolids& solids;
    Random &own, &shared;
    Vec3d at, normal;
};

/** `edgeM`: distance from the hairline. */
void combShort(const Root& root, double edgeM, HairLock& lock) {
    const Vec3d u = root.comb.from(root.at);
    const double top = rampd(u.y, 0.1, 0.75), inside = rampd(edgeM, 0.0, 0.035), front = rampd(u.z, 0.2, 0.6) * top;
    const double liftRad =
        glm::mix(0.32, 0.66, top) * (0.65 + 0.35 * inside) + 0.28 * front + 0.12 * root.shared.normal() + 0.07 * root.own.normal();
    const double turnRad = 0.22 * root.shared.normal() + 0.13 * root.own.normal();
    lock.lengthM = std::clamp(
        root.comb.length * glm::mix(0.024, 0.036, top) * (0.75 + 0.25 * inside) + 0.002 * root.own.normal() + 0.002 * root.shared.normal(),
        0.020, 0.040);
    lock.halfWidthM = root.own.uniform(0.0040, 0.0056), lock.halfThicknessM = root.own.uniform(0.0018, 0.0026);
    const Vec3d flow = shortFlow(root.comb, root.at, root.normal), across = glm::cross(root.normal, flow);
    const Vec3d turned = flow * std::cos(turnRad) + across * std::sin(turnRad);
    const Vec3d start = turned * std::cos(liftRad) + root.normal * std::sin(liftRad);
    const Vec3d end = glm::normalize(turned + 0.35 * std::sin(liftRad) * root.normal + 0.25 * kDown);
    Vec3d p = root.at - 0.0015 * root.normal;
    std::vector<Vec3d>& nodes = lock.groomed;
    nodes.push_back(p);
    const size_t count = lock.clearanceM.size();
    const double linkM = lock.lengthM / double(count - 1);
    for (size_t i = 1; i < count; ++i) {
        p += linkM * glm::normalize(glm::mix(start, end, (double(i) - 0.5) / double(count - 1)));
        lock.clearanceM[i] = 0.002 + lock.halfThicknessM;
        keepOut(p, nodes.back(), linkM, lock.clearanceM[i], root.solids);
        nodes.push_back(p);
    }
}

void combLong(const Root& root, HairLock& lock) {
    const Vec3d u = root.comb.from(root.at);
    const double top = rampd(u.y, -0.25, 0.75);
    lock.lengthM = std::clamp(root.comb.length * glm::mix(0.235, 0.335, top) * (1 + 0.05 * root.shared.normal() + 0.03 * root.own.normal()),
                              0.20, 0.35);
    lock.halfWidthM = root.own.uniform(0.0085, 0.0115), lock.halfThicknessM = root.own.uniform(0.0024, 0.0034);
    // Hair from the crown lies over that from the sides.
    const double layerM = 0.004 + lock.halfThicknessM + (0.003 + 0.012 * top) * root.own.uniform(0.2, 1.0);
    const size_t count = lock.clearanceM.size();
    const double linkM = lock.lengthM / double(count - 1);
    Vec3d p = root.at - 0.0015 * root.normal,
          before = glm::normalize(along(longFlow(root.comb, root.at), root.normal) + root.own.uniform(0.25, 0.55) * root.normal);
    std::vector<Vec3d>& nodes = lock.groomed;
    nodes.push_back(p);
    for (size_t i = 1; i < count; ++i) {
        lock.clearanceM[i] = std::max(0.003, layerM * std::min(1.0, double(i) / 3));
        const auto near = root.solids.nearest(p);
        Vec3d wanted = longFlow(root.comb, p);
        if (p.y < root.comb.middle.y - 0.09) wanted = kDown;
        if (near.distanceM < 0.035) wanted = along(wanted, near.outward);
        before = glm::normalize(0.4 * before + 0.6 * wanted);
        const Vec3d last = p;
        p += linkM * before;
        keepOut(p, last, linkM, lock.clearanceM[i], root.solids);
        before = glm::normalize(p - last);
        nodes.push_back(p);
    }
}

/** Where the hair layer ends. */
std::vector<Vec3d> hairline(const Subject& subject) {
    std::map<std::pair<uint32_t, uint32_t>, int> uses;
    const LayerData& layer =
        *std::find_if(subject.mesh.layers.begin(), subject.mesh.layers.end(), [](const LayerData& l) { return l.name == "hair"; });
    for (uint32_t t = layer.firstTriangle; t < subject.hair.firstTriangle; ++t)
        for (int c = 0; c < 3; ++c) ++uses[std::minmax(subject.mesh.triangles[t][c], subject.mesh.triangles[t][(c + 1) % 3])];
    std::vector<Vec3d> out;
    for (const auto& [edge, count] : uses)
        if (count == 1) out.push_back(Vec3d(subject.mesh.restPositions[edge.first]));
    return out;
}

void combAll(Subject& subject, const PosedSolids& solids) {
    HairLocks& hair = subject.hair;
    const Comb comb(subject, hair.style);
    const std::vector<Vec3d> border = hairline(subject);
    const std::vector<Vec3f> normals = vertexNormals(subject.mesh.restPositions, subject.mesh.triangles);
    std::vector<Vec3d> leaders;
    for (size_t i = 0; i < hair.locks.size(); ++i) {
        HairLock& lock = hair.locks[i];
        const Triangle& f = subject.mesh.triangles[lock.rootTriangle];
        Vec3d root(0), normal(0);
        for (int c = 0; c < 3; ++c) {
            root += double(lock.rootWeights[c]) * Vec3d(subject.mesh.restPositions[f[c]]);
            normal += double(lock.rootWeights[c]) * Vec3d(normals[f[c]]);
        }
        normal = glm::normalize(normal);
        if (i < hair.locks.size() / 5) leaders.push_back(root);  // neighbours lie alike: they share the chance of the nearest of these
        size_t leader = 0;
        for (size_t l = 1; l < leaders.size(); ++l)
            if (glm::distance(root, leaders[l]) < glm::distance(root, leaders[leader])) leader = l;
        Random own(subject.seed, kLockStream + i), shared(subject.seed, kNeighboursStream + leader);
        lock.clearanceM.assign(hair.nodesPerLock, 0.0);
        const Root place{comb, solids, own, shared, root, normal};
        if (hair.swing()) {
            combLong(place, lock);
        } else {
            double edgeM = 1;
            for (const Vec3d& b : border) edgeM = std::min(edgeM, glm::distance(b, root));
            combShort(place, edgeM, lock);
        }
        lock.rest = facingNodes(lock.groomed, normal, solids);
    }
}

/** Lets combed hair hang until it is still. */
void settle(HairLocks& hair, const PosedSolids& solids) {
    const size_t count = hair.nodesPerLock;
    std::vector<Vec3d> start;
    for (const HairLock& lock : hair.locks) start.insert(start.end(), lock.groomed.begin(), lock.groomed.end());
    LockChains chains(hair, std::move(start));
    const Mat3x4d still(1);
    for (double s = 0; s < kSettleS; s += LockChains::kStepS) chains.step(still, solids);
    for (size_t i = 0; i < hair.locks.size(); ++i) {
        const auto first = chains.nodes().begin() + std::ptrdiff_t(i * count);
        hair.locks[i].rest = facingNodes({first, first + std::ptrdiff_t(count)}, hair.locks[i].rest[0].facing, solids);
    }
}

}  // namespace

void growLocks(Subject& subject, Jobs& jobs) {
    HairLocks& hair = subject.hair;
    hair.solids = std::make_shared<const BodySolids>(subject, jobs);
    const PosedSolids solids(*hair.solids, std::vector<Mat3x4d>(subject.joints.size(), Mat3x4d(1)));
    combAll(subject, solids);
    if (hair.swing()) {
        Random random(subject.seed, kStyleStream + 1);
        hair.frequencyHz = random.uniform(0.6, 1.2), hair.damping = random.uniform(0.10, 0.25);
        settle(hair, solids);
    }
    dressLocks(subject);
}

}  // namespace dpl
