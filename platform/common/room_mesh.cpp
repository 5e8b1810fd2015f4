// SPDX-License-Identifier: Apache-2.0
#include "platform/common/room_mesh.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

namespace dpl::platform {
namespace {

struct Vec {
    float x = 0, y = 0, z = 0;
};

constexpr float kBackdropHeightM = 12, kColumnHeightM = 3.6f, kPostHalfM = 0.06f;

/** A ring of a surface of revolution: radius and height, the outward normal in the plane of the axis, and how open it is. */
struct Ring {
    float radius, y, normalOut, normalUp, open;
};

class MeshMaker {
public:
    explicit MeshMaker(std::vector<RoomVertex>& out) : out_(out) {}

    void triangle(RoomSurface surface, const Vec (&p)[3], const Vec (&n)[3], const float (&open)[3]) {
        for (int i = 0; i < 3; ++i) out_.push_back({{p[i].x, p[i].y, p[i].z}, {n[i].x, n[i].y, n[i].z}, float(surface), open[i]});
    }

    /** Joins rings around a vertical axis at (x, z); the order of the rings is upwards on the outside. */
    void revolve(RoomSurface surface, float x, float z, const std::vector<Ring>& rings, int sides) {
        for (size_t r = 0; r + 1 < rings.size(); ++r)
            for (int s = 0; s < sides; ++s) {
                const float a = angle(s, sides), b = angle(s + 1, sides);
                const Ring &low = rings[r], &high = rings[r + 1];
                const Vec p[4] = {at(low, a, x, z), at(low, b, x, z), at(high, b, x, z), at(high, a, x, z)};
                const Vec n[4] = {normal(low, a), normal(low, b), normal(high, b), normal(high, a)};
                if (low.radius > 0) triangle(surface, {p[0], p[1], p[2]}, {n[0], n[1], n[2]}, {low.open, low.open, high.open});
                if (high.radius > 0) triangle(surface, {p[0], p[2], p[3]}, {n[0], n[2], n[3]}, {low.open, high.open, high.open});
            }
    }

    /** An upright box around (x, z). */
    void box(RoomSurface surface, float x, float z, float half, float low, float high) {
        const float sides[4][2] = {{0, 1}, {1, 0}, {0, -1}, {-1, 0}};
        for (const auto& side : sides) {
            const Vec n{side[0], 0, side[1]}, along{side[1], 0, -side[0]};
            quad(surface, {x + half * n.x, low, z + half * n.z}, {half * along.x, 0, half * along.z}, high - low, n);
        }
        const Vec up{0, 1, 0}, down{0, -1, 0};
        const Vec c[4] = {{x - half, high, z + half}, {x + half, high, z + half}, {x + half, high, z - half}, {x - half, high, z - half}};
        triangle(surface, {c[0], c[1], c[2]}, {up, up, up}, {1, 1, 1});
        triangle(surface, {c[0], c[2], c[3]}, {up, up, up}, {1, 1, 1});
        const auto below = [&](const Vec& v) { return Vec{v.x, low, v.z}; };
        triangle(surface, {below(c[2]), below(c[1]), below(c[0])}, {down, down, down}, {1, 1, 1});
        triangle(surface, {below(c[3]), below(c[2]), below(c[0])}, {down, down, down}, {1, 1, 1});
    }

private:
    static float angle(int side, int sides) { return 2 * std::numbers::pi_v<float> * float(side % sides) / float(sides); }
    static Vec at(const Ring& ring, float a, float x, float z) {
        return {x + ring.radius * std::sin(a), ring.y, z + ring.radius * std::cos(a)};
    }
    static Vec normal(const Ring& ring, float a) { return {ring.normalOut * std::sin(a), ring.normalUp, ring.normalOut * std::cos(a)}; }

    /** A side of a box: `middle` is the middle of its lower edge. */
    void quad(RoomSurface surface, const Vec& middle, const Vec& half, float height, const Vec& n) {
        const Vec a{middle.x - half.x, middle.y, middle.z - half.z}, b{middle.x + half.x, middle.y, middle.z + half.z};
        const Vec c{b.x, b.y + height, b.z}, d{a.x, a.y + height, a.z};
        triangle(surface, {a, b, c}, {n, n, n}, {1, 1, 1});
        triangle(surface, {a, c, d}, {n, n, n}, {1, 1, 1});
    }

    std::vector<RoomVertex>& out_;
};

/** What darkens the floor around it. */
struct Body {
    float x, z, radius, reach;
};

/** How open the floor is at (x, z): less near each body. Shadows that overlap agree where they do, so no edge shows. */
float openOfFloor(const std::vector<Body>& bodies, float x, float z) {
    float open = 1;
    for (const Body& body : bodies) {
        const float t = std::clamp((std::hypot(x - body.x, z - body.z) - body.radius) / body.reach, 0.0f, 1.0f);
        open *= 0.45f + 0.55f * t * (2 - t);
    }
    return open;
}

/** The floor around a body, a little higher than the rest of the floor. */
void addFloorShadow(MeshMaker& maker, const std::vector<Body>& bodies, const Body& body, float floorY) {
    constexpr float kRings[] = {1, 0.7f, 0.45f, 0.25f, 0.1f, -0.05f};
    constexpr int kSides = 48;
    const auto at = [&](float ring, int side) {
        const float a = 2 * std::numbers::pi_v<float> * float(side % kSides) / kSides, r = body.radius + ring * body.reach;
        return Vec{body.x + r * std::sin(a), floorY + 0.002f, body.z + r * std::cos(a)};
    };
    const auto open = [&](const Vec& p) { return openOfFloor(bodies, p.x, p.z); };
    const Vec up{0, 1, 0};
    for (size_t r = 0; r + 1 < std::size(kRings); ++r)
        for (int s = 0; s < kSides; ++s) {
            const Vec a = at(kRings[r], s), b = at(kRings[r], s + 1), c = at(kRings[r + 1], s + 1), d = at(kRings[r + 1], s);
            maker.triangle(RoomSurface::Floor, {a, b, c}, {up, up, up}, {open(a), open(b), open(c)});
            maker.triangle(RoomSurface::Floor, {a, c, d}, {up, up, up}, {open(a), open(c), open(d)});
        }
}

void addColumn(MeshMaker& maker, float x, float z, float floorY) {
    const float plinth = floorY + 0.14f, top = floorY + kColumnHeightM - 0.16f;
    maker.box(RoomSurface::Column, x, z, 0.24f, floorY, plinth);
    maker.revolve(RoomSurface::Column, x, z,
                  {{0.2f, plinth, 1, 0, 0.7f},
                   {0.2f, plinth + 0.05f, 0.8f, 0.6f, 0.9f},
                   {0.165f, plinth + 0.1f, 1, 0, 0.9f},
                   {0.155f, plinth + 1.2f, 1, 0, 1},
                   {0.14f, top - 0.08f, 1, 0, 0.9f},
                   {0.19f, top, 0.8f, -0.6f, 0.8f}},
                  20);
    maker.box(RoomSurface::Column, x, z, 0.22f, top, floorY + kColumnHeightM);
}

void addStand(MeshMaker& maker, float x, float z, float floorY) {
    const float top = floorY + kStandHeightM, r = kStandRadiusM;
    maker.revolve(RoomSurface::Stand, x, z, {{r, floorY, 1, 0, 0.6f}, {r, top - 0.02f, 1, 0, 1}, {r - 0.02f, top, 0.7f, 0.7f, 1}}, 64);
    // The shadow of feet in the middle.
    maker.revolve(
        RoomSurface::Stand, x, z,
        {{r - 0.02f, top, 0, 1, 1}, {0.36f, top, 0, 1, 0.98f}, {0.24f, top, 0, 1, 0.82f}, {0.12f, top, 0, 1, 0.6f}, {0, top, 0, 1, 0.52f}},
        64);
}

}  // namespace

std::vector<RoomVertex> roomMesh(const RoomPlan& plan) {
    std::vector<RoomVertex> mesh;
    MeshMaker maker(mesh);
    const float floorY = plan.floorY, ring = std::clamp(plan.ringRadiusM, kMinRingRadiusM, kMaxRingRadiusM);
    const float wall = std::max(16.0f, ring + 8), ceiling = floorY + kBackdropHeightM;
    // A square around the wall, because a corner just beside the eye has no place on the screen: drivers that compute with projected
    // corners lose what the triangle shows in front of the eye. So no corner lies where a user stands.
    const Vec up{0, 1, 0}, corners[4] = {{-wall, floorY, wall}, {wall, floorY, wall}, {wall, floorY, -wall}, {-wall, floorY, -wall}};
    maker.triangle(RoomSurface::Floor, {corners[0], corners[1], corners[2]}, {up, up, up}, {1, 1, 1});
    maker.triangle(RoomSurface::Floor, {corners[0], corners[2], corners[3]}, {up, up, up}, {1, 1, 1});
    // From the top down, so that its inside is its front.
    maker.revolve(RoomSurface::Backdrop, 0, 0, {{0, ceiling, 0, -1, 1}, {wall, ceiling, -1, 0, 1}, {wall, floorY, -1, 0, 0}}, 64);
    std::vector<Body> bodies;
    // Even, so that the view from the front is symmetric; about 3.3 m apart.
    const int columns = 2 * int(std::lround(std::numbers::pi_v<float> * ring / 3.3f));
    for (int i = 0; i < columns; ++i) {
        const float a = 2 * std::numbers::pi_v<float> * (float(i) + 0.5f) / float(columns);
        bodies.push_back({ring * std::sin(a), ring * std::cos(a), 0.24f, 0.5f});
        addColumn(maker, bodies.back().x, bodies.back().z, floorY);
    }
    const float low = floorY + kColumnHeightM, high = low + 0.34f, in = ring - 0.26f, out = ring + 0.26f;
    maker.revolve(RoomSurface::Column, 0, 0, {{in, low, 0, -1, 0.8f}, {out, low, 0, -1, 0.8f}}, 64);
    maker.revolve(RoomSurface::Column, 0, 0, {{out, low, 1, 0, 1}, {out, high, 1, 0, 1}}, 64);
    maker.revolve(RoomSurface::Column, 0, 0, {{out, high, 0, 1, 1}, {in, high, 0, 1, 1}}, 64);
    maker.revolve(RoomSurface::Column, 0, 0, {{in, high, -1, 0, 1}, {in, low, -1, 0, 1}}, 64);
    for (size_t i = 0; i < std::min<size_t>(plan.stands.size(), kMaxStands); ++i) {
        bodies.push_back({plan.stands[i][0], plan.stands[i][1], kStandRadiusM, 0.6f});
        addStand(maker, bodies.back().x, bodies.back().z, floorY);
    }
    for (size_t i = 0; i < std::min<size_t>(plan.posts.size(), kMaxPosts); ++i) {
        bodies.push_back({plan.posts[i][0], plan.posts[i][1], kPostHalfM, 0.25f});
        maker.box(RoomSurface::Column, bodies.back().x, bodies.back().z, kPostHalfM, floorY, floorY + kPostHeightM);
    }
    for (const Body& body : bodies) addFloorShadow(maker, bodies, body, floorY);
    return mesh;
}

uint32_t maxRoomVertices() {
    const size_t empty = roomMesh({kMaxRingRadiusM, 0, {}, {}}).size(), stand = roomMesh({kMaxRingRadiusM, 0, {{0, 0}}, {}}).size() - empty,
                 post = roomMesh({kMaxRingRadiusM, 0, {}, {{0, 0}}}).size() - empty;
    return uint32_t(empty + kMaxStands * stand + kMaxPosts * post);
}

}  // namespace dpl::platform
