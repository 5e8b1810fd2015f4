// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/sample/raycast.h"

#if __has_include(<embree4/rtcore.h>)  // Debian 13
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "reconstruction/subject/sample/random.h"
#include "reconstruction/subject/sample/skeleton.h"

namespace dpl {
namespace {

constexpr float kClothThicknessM = 0.002f;
constexpr uint32_t kNotDrawn = ~0u;
const Vec4f kLightSteps(0.6180340f, 0.7548777f, 0.5698403f, 0.8191725f);  // light samples: four additive recurrences, one per dimension
constexpr float kRayOffsetM = 4e-4f;  // origin of a shadow ray above the surface, so that it does not hit that surface

const Vec3f kSunDirection = glm::normalize(Vec3f(0.52f, 0.78f, 0.62f));
const Vec3f kSunColour(1.62f, 1.50f, 1.32f);
const Vec3f kSkyColour(0.60f, 0.66f, 0.76f), kGroundBounce(0.24f, 0.21f, 0.18f);

Vec3f skyLight(const Vec3f& d) {
    return d.y >= 0 ? kSkyColour * (0.75f + 0.45f * d.y) : kGroundBounce;
}

/** Linear light to display-referred: exponential tone curve, then the sRGB curve. */
float display(float x) {
    x = 1 - std::exp(-1.05f * std::max(x, 0.0f));
    return x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1 / 2.4f) - 0.055f;
}

void basis(const Vec3f& n, Vec3f& a, Vec3f& b) {
    a = glm::normalize(std::abs(n.y) < 0.9f ? glm::cross(Vec3f(0, 1, 0), n) : glm::cross(Vec3f(1, 0, 0), n));
    b = glm::cross(n, a);
}

float hash01(uint32_t x, uint32_t y, uint32_t salt) {
    return float(mixBits(uint64_t(x) << 40 ^ uint64_t(y) << 20 ^ salt) >> 40) * 0x1p-24f;
}

/** Albedo of a print that looks different everywhere: coloured squares of three sizes in three directions, so that its corners are seen
 * from near and from far. x, y: place on it, metres. */
Vec3f print(float x, float y, uint32_t salt) {
    constexpr float sizeM[] = {0.55f, 0.21f, 0.085f}, angle[] = {0.1f, 0.6f, 1.2f}, weight[] = {0.35f, 0.35f, 0.3f};
    Vec3f albedo(0.08f);
    for (uint32_t i = 0; i < 3; ++i) {
        const float c = std::cos(angle[i]) / sizeM[i], s = std::sin(angle[i]) / sizeM[i];
        const uint32_t column = uint32_t(int(std::floor(c * x + s * y)) + 4096), row = uint32_t(int(std::floor(c * y - s * x)) + 4096);
        for (int k = 0; k < 3; ++k) albedo[k] += 0.6f * weight[i] * hash01(column, row, 40 + 16 * salt + 4 * i + uint32_t(k));
    }
    return albedo;
}

#if RTC_VERSION_MAJOR >= 4
void castRay(RTCScene scene, RTCRayHit& ray) {
    rtcIntersect1(scene, &ray);
}
void shadowRay(RTCScene scene, RTCRay& ray) {
    rtcOccluded1(scene, &ray);
}
#else
void castRay(RTCScene scene, RTCRayHit& ray) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene, &context, &ray);
}
void shadowRay(RTCScene scene, RTCRay& ray) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene, &context, &ray);
}
#endif

}  // namespace

struct PersonTracer::State {
    const Subject& subject;
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;
    // The drawn mesh: all vertices of the subject, then copies for the inner side of clothes, shoes and hair.
    std::vector<uint32_t> sourceVertex;  // per drawn vertex: vertex of the subject
    std::vector<Triangle> triangles;
    std::vector<uint8_t> label;   // per drawn triangle: SubjectLabel
    std::vector<uint32_t> drawn;  // per triangle of the subject: the drawn one on its outer side; kNotDrawn where it is hidden
    std::vector<uint8_t> inner;   // per drawn vertex: 1 on the inner side
    std::vector<Vec3f> at, normal;
    Vec3f low{0}, high{0};

    explicit State(const Subject& s) : subject(s) {
        const MeshData& mesh = s.mesh;
        const uint32_t count = uint32_t(mesh.restPositions.size());
        for (uint32_t v = 0; v < count; ++v) sourceVertex.push_back(v), inner.push_back(0);
        drawn.assign(mesh.triangles.size(), kNotDrawn);
        for (size_t i = 0; i < s.parts.size(); ++i) {
            const LayerData& layer = mesh.layers[i];
            std::map<std::pair<uint32_t, uint32_t>, int> edges;
            std::vector<uint32_t> innerOf(layer.vertexCount);
            if (i > 0)
                for (uint32_t v = 0; v < layer.vertexCount; ++v) {
                    innerOf[v] = uint32_t(sourceVertex.size());
                    sourceVertex.push_back(layer.firstVertex + v);
                    inner.push_back(1);
                }
            const bool locks = s.parts[i].label == kLabelHair && s.hair.style != Hairstyle::Cap;
            for (uint32_t t = layer.firstTriangle; t < layer.firstTriangle + layer.triangleCount; ++t) {
                if (s.hiddenFace[t]) continue;
                const Triangle f = mesh.triangles[t];
                drawn[t] = uint32_t(triangles.size());
                add(f, s.parts[i].label);
                if (i == 0 || (locks && t >= s.hair.firstTriangle)) continue;  // bodies and locks are solids
                auto in = [&](uint32_t v) { return innerOf[v - layer.firstVertex]; };
                add({in(f.x), in(f.z), in(f.y)}, s.parts[i].label);
                for (int c = 0; c < 3; ++c) edges[{f[c], f[(c + 1) % 3]}] = 1;
            }
            for (const auto& [edge, one] : edges)
                if (!edges.contains({edge.second, edge.first})) {  // a hem: connect outer and inner side
                    const uint32_t a = edge.first, b = edge.second, ia = innerOf[a - layer.firstVertex],
                                   ib = innerOf[b - layer.firstVertex];
                    add({b, a, ia}, s.parts[i].label);
                    add({b, ia, ib}, s.parts[i].label);
                }
        }
        device = rtcNewDevice("threads=1,set_affinity=0");
    }
    ~State() {
        if (scene) rtcReleaseScene(scene);
        if (device) rtcReleaseDevice(device);
    }
    void add(const Triangle& t, uint8_t l) { triangles.push_back(t), label.push_back(l); }

    bool blocked(const Vec3f& from, const Vec3f& direction, float limit) const {
        RTCRay ray{};
        ray.org_x = from.x, ray.org_y = from.y, ray.org_z = from.z;
        ray.dir_x = direction.x, ray.dir_y = direction.y, ray.dir_z = direction.z;
        ray.tnear = 0, ray.tfar = limit, ray.mask = ~0u;
        shadowRay(scene, ray);
        return ray.tfar < 0;
    }

    struct Hit {
        bool found = false;
        float distance = 0;
        uint32_t triangle = 0;
        float u = 0, v = 0;
    };
    Hit trace(const Vec3f& from, const Vec3f& direction) const {
        RTCRayHit ray{};
        ray.ray.org_x = from.x, ray.ray.org_y = from.y, ray.ray.org_z = from.z;
        ray.ray.dir_x = direction.x, ray.ray.dir_y = direction.y, ray.ray.dir_z = direction.z;
        ray.ray.tfar = std::numeric_limits<float>::infinity();
        ray.ray.mask = ~0u;
        ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        castRay(scene, ray);
        if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
        return {true, ray.ray.tfar, ray.hit.primID, ray.hit.u, ray.hit.v};
    }

    /** Light reflected to the eye, linear RGB. r: random numbers in [0, 1), xy for the sun and zw for the sky. */
    Vec3f shadePerson(const Hit& hit, const Vec3f& eye, const Vec3f& direction, float footprint, const Vec4f& r) const {
        const Triangle& f = triangles[hit.triangle];
        const float w = 1 - hit.u - hit.v;
        const Vec3f point = eye + direction * hit.distance;
        Vec3f face = glm::normalize(glm::cross(at[f.y] - at[f.x], at[f.z] - at[f.x]));
        if (glm::dot(face, direction) > 0) face = -face;
        Vec3f n = glm::normalize(w * normal[f.x] + hit.u * normal[f.y] + hit.v * normal[f.z]);
        if (glm::dot(n, face) < 0) n = face;
        const auto& c = subject.canonical;
        const Vec3f canonical = w * c[sourceVertex[f.x]] + hit.u * c[sourceVertex[f.y]] + hit.v * c[sourceVertex[f.z]];
        const SurfaceColour colour = surfaceColour(subject.look, label[hit.triangle], canonical, footprint);
        const Vec3f origin = point + face * kRayOffsetM;

        Vec3f a, b;
        basis(kSunDirection, a, b);
        const float radius = 0.035f * std::sqrt(r.x), angle = 6.2831853f * r.y;  // a sun of 2° radius gives soft shadow edges
        const Vec3f sun = glm::normalize(kSunDirection + a * (radius * std::cos(angle)) + b * (radius * std::sin(angle)));
        const float cosSun = glm::dot(n, sun);
        Vec3f light(0);
        bool lit = false;
        if (cosSun > 0 && glm::dot(face, sun) > 0) lit = !blocked(origin, sun, 4.0f);
        if (lit) light += kSunColour * cosSun;

        basis(n, a, b);
        const float sinT = std::sqrt(r.z), cosT = std::sqrt(1 - r.z), phi = 6.2831853f * r.w;
        const Vec3f up = a * (sinT * std::cos(phi)) + b * (sinT * std::sin(phi)) + n * cosT;
        const Vec3f mean = skyLight(n) * 0.5f + (kSkyColour * (0.55f + 0.35f * n.y) + kGroundBounce * (0.45f - 0.35f * n.y)) * 0.5f;
        const bool open = !blocked(origin, up, 0.7f);
        // Mean sky light. A surface within 0.7 m blocks most of it and reflects some light, assumed to have this point's colour.
        light += open ? mean : mean * 0.18f + colour.albedo * 0.10f;

        const float grazing = std::pow(1 - std::max(0.0f, glm::dot(n, -direction)), 4.0f);
        Vec3f out = colour.albedo * light + colour.sheen * 0.22f * grazing * light * (0.3f + 0.7f * colour.albedo);
        if (colour.gloss > 0 && lit) {
            const Vec3f halfway = glm::normalize(sun - direction);
            out += colour.gloss * kSunColour * 0.8f * std::pow(std::max(0.0f, glm::dot(n, halfway)), 60.0f);
        }
        return out;
    }

    Vec3f background(const Vec3f& eye, const Vec3f& d, const Vec4f& r, bool posters) const {
        constexpr float roomRadius = 5.0f;
        // Distance to the cylindrical wall.
        const float dd = d.x * d.x + d.z * d.z, ed = eye.x * d.x + eye.z * d.z,
                    ee = eye.x * eye.x + eye.z * eye.z - roomRadius * roomRadius;
        const float wall = dd > 1e-9f ? (-ed + std::sqrt(std::max(0.0f, ed * ed - dd * ee))) / dd : 1e9f;
        const float floor = d.y < -1e-6f ? -eye.y / d.y : 1e9f;
        if (floor < wall) {
            const Vec3f p = eye + d * floor;
            const float board = std::floor(p.x / 0.22f),
                        tone = hash01(uint32_t(int(board) + 1000), uint32_t(int(std::floor(p.z / 1.3f + 0.5f * board)) + 1000), 7);
            const float gap = std::abs(p.x / 0.22f - board - 0.5f) > 0.488f ? 0.80f : 1.0f;
            Vec3f albedo = Vec3f(0.42f, 0.34f, 0.26f) * (0.86f + 0.22f * tone) * gap;
            if (posters) albedo = print(p.x, p.z, 0);
            const float from = std::sqrt(p.x * p.x + p.z * p.z);
            Vec3f light = kSunColour * kSunDirection.y, sky = kSkyColour * 0.95f;
            if (from < 2.6f) {
                Vec3f a, b;
                basis(kSunDirection, a, b);
                const float radius = 0.035f * std::sqrt(r.x), angle = 6.2831853f * r.y;
                if (blocked(p + Vec3f(0, kRayOffsetM, 0),
                            glm::normalize(kSunDirection + a * (radius * std::cos(angle)) + b * (radius * std::sin(angle))), 5))
                    light = Vec3f(0);
            }
            if (from < 0.8f) {
                const float sinT = std::sqrt(r.z), phi = 6.2831853f * r.w;
                if (blocked(p + Vec3f(0, kRayOffsetM, 0), {sinT * std::cos(phi), std::sqrt(1 - r.z), sinT * std::sin(phi)}, 0.6f))
                    sky *= 0.25f;
            }
            return albedo * (light + sky);
        }
        const Vec3f p = eye + d * wall;
        const float turn = std::atan2(p.x, p.z), panel = std::floor(turn * 9);
        const float tone = hash01(uint32_t(int(panel) + 100), 3, 11);
        const Vec3f paint = posters ? print(turn * roomRadius, p.y, 1) : Vec3f(0.50f, 0.52f, 0.54f) * (0.85f + 0.18f * tone);
        return paint * (0.75f + 0.16f * std::min(p.y, 3.0f)) + Vec3f(0.02f) * float(p.y < 0.12f);
    }
};

PersonTracer::PersonTracer(const Subject& subject) : state_(std::make_unique<State>(subject)) {}
PersonTracer::~PersonTracer() = default;

void PersonTracer::setVertices(const std::vector<Vec3d>& vertices) {
    State& s = *state_;
    std::vector<Vec3f> outerNormal(vertices.size(), Vec3f(0));
    for (const Triangle& t : s.subject.mesh.triangles) {
        const Vec3f n(glm::cross(vertices[t.y] - vertices[t.x], vertices[t.z] - vertices[t.x]));
        outerNormal[t.x] += n, outerNormal[t.y] += n, outerNormal[t.z] += n;
    }
    s.at.resize(s.sourceVertex.size());
    s.normal.resize(s.sourceVertex.size());
    s.low = Vec3f(1e9f), s.high = Vec3f(-1e9f);
    for (size_t v = 0; v < s.at.size(); ++v) {
        const uint32_t source = s.sourceVertex[v];
        const float length = glm::length(outerNormal[source]);
        const Vec3f n = length > 0 ? outerNormal[source] / length : Vec3f(0, 1, 0);
        s.normal[v] = s.inner[v] ? -n : n;
        s.at[v] = Vec3f(vertices[source]) - (s.inner[v] ? kClothThicknessM : 0.0f) * n;
        s.low = glm::min(s.low, s.at[v]), s.high = glm::max(s.high, s.at[v]);
    }
    if (s.scene) rtcReleaseScene(s.scene);
    s.scene = rtcNewScene(s.device);
    RTCGeometry geometry = rtcNewGeometry(s.device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* points = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), s.at.size()));
    for (size_t v = 0; v < s.at.size(); ++v) points[3 * v] = s.at[v].x, points[3 * v + 1] = s.at[v].y, points[3 * v + 2] = s.at[v].z;
    auto* faces = static_cast<uint32_t*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t), s.triangles.size()));
    for (size_t t = 0; t < s.triangles.size(); ++t)
        faces[3 * t] = s.triangles[t].x, faces[3 * t + 1] = s.triangles[t].y, faces[3 * t + 2] = s.triangles[t].z;
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(s.scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(s.scene);
}

std::optional<Vec3f> PersonTracer::colourAt(uint32_t triangle, float u, float v, float footprintM, uint32_t samples) const {
    const State& s = *state_;
    const uint32_t drawn = s.drawn[triangle];
    if (drawn == kNotDrawn) return std::nullopt;
    const Triangle& f = s.triangles[drawn];
    const Vec3f point = (1 - u - v) * s.at[f.x] + u * s.at[f.y] + v * s.at[f.z];
    const Vec3f normal = glm::normalize(glm::cross(s.at[f.y] - s.at[f.x], s.at[f.z] - s.at[f.x]));
    Vec3f sum(0);
    const uint32_t place = uint32_t(u * 4096) << 12 | uint32_t(v * 4096);
    const Vec4f start{hash01(triangle, place, 0), hash01(triangle, place, 1), hash01(triangle, place, 2), hash01(triangle, place, 3)};
    for (uint32_t i = 0; i < samples; ++i) {
        const Vec4f r = glm::fract(start + kLightSteps * float(i));
        sum += s.shadePerson({true, 1.5f, drawn, u, v}, point + 1.5f * normal, -normal, footprintM, r);
    }
    sum /= float(samples);
    return Vec3f(display(sum.x), display(sum.y), display(sum.z));
}

double PersonTracer::firstHit(const Vec3d& from, const Vec3d& to) const {
    const Vec3d d = to - from;
    const double length = glm::length(d);
    const auto hit = state_->trace(Vec3f(from), Vec3f(d / length));
    return hit.found ? double(hit.distance) / length : 1e9;
}

RaycastFrame PersonTracer::render(const Camerad& camera, const RaycastOptions& options) const {
    const State& s = *state_;
    const uint32_t w = camera.widthPx, h = camera.heightPx, n = std::max(1u, options.samplesPerPixel);
    const uint32_t columns = std::max(1u, uint32_t(std::sqrt(double(n)) + 1e-9)),
                   rows = (n + columns - 1) / columns;  // grid of strata in a pixel
    RaycastFrame frame;
    frame.rgb.resize(size_t(w) * h * 3);
    frame.mask.resize(size_t(w) * h);
    frame.labels.resize(size_t(w) * h);
    const Vec3f eye(camera.eye());
    const Mat3f worldFromView(glm::transpose(camera.viewFromWorldRotation));
    // Pixels that can see the person: those within its projected bounding box, or all if a corner is nearer than 5 cm or behind the eye.
    double minX = 1e9, maxX = -1e9, minY = 1e9, maxY = -1e9;
    for (int c = 0; c < 8; ++c) {
        const Vec3d view = camera.toView({c & 1 ? s.high.x : s.low.x, c & 2 ? s.high.y : s.low.y, c & 4 ? s.high.z : s.low.z});
        if (view.z < 0.05) {
            minX = minY = -1e9, maxX = maxY = 1e9;
            break;
        }
        const double x = camera.fx * view.x / view.z + camera.cx, y = camera.fy * view.y / view.z + camera.cy;
        minX = std::min(minX, x), maxX = std::max(maxX, x), minY = std::min(minY, y), maxY = std::max(maxY, y);
    }
    const uint32_t frameSalt = uint32_t(options.seed * 2654435761u);
    for (uint32_t y = 0; y < h; ++y)
        for (uint32_t x = 0; x < w; ++x) {
            const bool mayHit = x + 1 >= minX && x <= maxX && y + 1 >= minY && y <= maxY;
            Vec3f sum(0);
            std::array<uint8_t, 6> votes{};
            // Light samples: each recurrence starts at a hash of the pixel.
            const float h0 = hash01(x, y, frameSalt), h1 = hash01(x, y, frameSalt + 1), h2 = hash01(x, y, frameSalt + 2),
                        h3 = hash01(x, y, frameSalt + 3);
            for (uint32_t i = 0; i < n; ++i) {
                const float jx = hash01(x, y, frameSalt + 16 + 2 * i), jy = hash01(x, y, frameSalt + 17 + 2 * i);
                const float px = float(x) + (float(i % columns) + jx) / float(columns);
                const float py = float(y) + (float(i / columns) + jy) / float(rows);
                const Vec4f r = glm::fract(Vec4f(h0, h1, h2, h3) + kLightSteps * float(i));
                const Vec3f view((px - float(camera.cx)) / float(camera.fx), (py - float(camera.cy)) / float(camera.fy), 1);
                const Vec3f direction = glm::normalize(worldFromView * view);
                State::Hit hit;
                if (mayHit) hit = s.trace(eye, direction);
                if (hit.found) {
                    const float footprint = hit.distance / float(camera.fx) * 0.75f;
                    sum += s.shadePerson(hit, eye, direction, footprint, r);
                    ++votes[s.label[hit.triangle]];
                } else {
                    sum += s.background(eye, direction, r, options.posters);
                    ++votes[0];
                }
            }
            const size_t pixel = size_t(y) * w + x;
            const bool person = 2u * (n - votes[0]) >= n && votes[0] < n;
            frame.mask[pixel] = person ? 255 : 0;
            if (person) frame.labels[pixel] = uint8_t(std::max_element(votes.begin() + 1, votes.end()) - votes.begin());
            for (int c = 0; c < 3; ++c) {
                // A sum of three uniform numbers approximates a Gaussian; times 2 its variance is 1.
                const float noise = (hash01(x, y, frameSalt + 101 + 3 * c) + hash01(x, y, frameSalt + 102 + 3 * c) +
                                     hash01(x, y, frameSalt + 103 + 3 * c) - 1.5f) *
                                    2;
                const float value = display(float(options.gain) * sum[c] / float(n)) + float(options.sensorNoise) * noise;
                frame.rgb[3 * pixel + c] = uint8_t(std::clamp(value * 255 + 0.5f, 0.0f, 255.0f));
            }
        }
    return frame;
}

}  // namespace dpl
