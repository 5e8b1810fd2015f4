// SPDX-License-Identifier: Apache-2.0
// What programs write into JPEG and PNG files beside the pixels: colour profiles, chunks, and damage.
#pragma once

#include <zlib.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace dpl {

using MadeBytes = std::vector<uint8_t>;

inline void appendBig(MadeBytes& out, uint32_t value, int bytes = 4) {
    for (int shift = 8 * (bytes - 1); shift >= 0; shift -= 8) out.push_back(uint8_t(value >> shift));
}
inline void appendText(MadeBytes& out, const std::string& text) {
    out.insert(out.end(), text.begin(), text.end());
}

/** An ICC profile of one curve and three primaries, XYZ at D50. curve: a tag of type "curv" or "para". */
inline MadeBytes madeProfile(const std::string& name, const MadeBytes& curve, const double (&xyz)[3][3], const char* space = "RGB ") {
    std::vector<std::pair<std::string, MadeBytes>> tags;
    MadeBytes desc;
    appendText(desc, "desc"), appendBig(desc, 0), appendBig(desc, uint32_t(name.size() + 1)), appendText(desc, name), desc.push_back(0);
    tags.emplace_back("desc", desc);
    for (int c = 0; c < 3; ++c) {
        MadeBytes primary;
        appendText(primary, "XYZ "), appendBig(primary, 0);
        for (double v : xyz[c]) appendBig(primary, uint32_t(int32_t(std::lround(v * 65536))));
        tags.emplace_back(std::string(1, "rgb"[c]) + "XYZ", primary);
        tags.emplace_back(std::string(1, "rgb"[c]) + "TRC", curve);
    }
    tags.emplace_back("kTRC", curve);
    MadeBytes profile(128), data;
    const size_t begin = 128 + 4 + 12 * tags.size();
    appendBig(profile, uint32_t(tags.size()));
    for (const auto& [tag, bytes] : tags) {
        appendText(profile, tag), appendBig(profile, uint32_t(begin + data.size())), appendBig(profile, uint32_t(bytes.size()));
        data.insert(data.end(), bytes.begin(), bytes.end());
        while (data.size() % 4 != 0) data.push_back(0);
    }
    profile.insert(profile.end(), data.begin(), data.end());
    MadeBytes size;
    appendBig(size, uint32_t(profile.size()));
    std::copy(size.begin(), size.end(), profile.begin());
    const std::string fields[] = {space, "XYZ ", "acsp"};
    const size_t places[] = {16, 20, 36};
    for (int i = 0; i < 3; ++i) std::copy(fields[i].begin(), fields[i].end(), profile.begin() + std::ptrdiff_t(places[i]));
    profile[8] = 4, profile[12] = 'm', profile[13] = 'n', profile[14] = 't', profile[15] = 'r';
    return profile;
}

/** The curve of sRGB, which Display P3 has too: function 3 of "para". */
inline MadeBytes srgbCurve() {
    MadeBytes curve;
    appendText(curve, "para"), appendBig(curve, 0), appendBig(curve, 3, 2), appendBig(curve, 0, 2);
    for (double v : {2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045}) appendBig(curve, uint32_t(std::lround(v * 65536)));
    return curve;
}
/** One gamma: "curv" of one entry, in 1/256. */
inline MadeBytes gammaCurve(double gamma) {
    MadeBytes curve;
    appendText(curve, "curv"), appendBig(curve, 0), appendBig(curve, 1), appendBig(curve, uint32_t(std::lround(gamma * 256)), 2);
    return curve;
}

constexpr double kMadeP3[3][3] = {{0.51512, 0.24120, -0.00105}, {0.29198, 0.69225, 0.04189}, {0.15710, 0.06657, 0.78407}};
constexpr double kMadeSrgb[3][3] = {{0.43607, 0.22249, 0.01392}, {0.38515, 0.71687, 0.09708}, {0.14307, 0.06061, 0.71410}};
constexpr double kMadeAdobe[3][3] = {{0.60974, 0.31111, 0.01947}, {0.20528, 0.62567, 0.06087}, {0.14919, 0.06322, 0.74457}};

inline MadeBytes displayP3Profile() {
    return madeProfile("Display P3", srgbCurve(), kMadeP3);
}

/** A JPEG with a segment after its start. */
inline MadeBytes withSegment(const MadeBytes& jpeg, uint8_t marker, const MadeBytes& payload) {
    MadeBytes out(jpeg.begin(), jpeg.begin() + 2);
    out.push_back(0xff), out.push_back(marker), appendBig(out, uint32_t(payload.size() + 2), 2);
    out.insert(out.end(), payload.begin(), payload.end());
    out.insert(out.end(), jpeg.begin() + 2, jpeg.end());
    return out;
}

/** A JPEG with an ICC profile, cut into so many segments, which are stored in reverse order. */
inline MadeBytes withProfile(MadeBytes jpeg, const MadeBytes& profile, size_t parts = 1) {
    const size_t step = (profile.size() + parts - 1) / parts;
    for (size_t i = 0; i < parts; ++i) {
        MadeBytes payload;
        appendText(payload, std::string("ICC_PROFILE\0", 12));
        payload.push_back(uint8_t(i + 1)), payload.push_back(uint8_t(parts));
        payload.insert(payload.end(), profile.begin() + std::ptrdiff_t(i * step),
                       profile.begin() + std::ptrdiff_t(std::min(profile.size(), (i + 1) * step)));
        jpeg = withSegment(jpeg, 0xe2, payload);
    }
    return jpeg;
}

/** A PNG with a chunk after its header, or before its end. */
inline MadeBytes withChunk(const MadeBytes& png, const std::string& type, const MadeBytes& data, bool atEnd = false) {
    MadeBytes chunk, checked;
    appendBig(chunk, uint32_t(data.size()));
    appendText(checked, type);
    checked.insert(checked.end(), data.begin(), data.end());
    chunk.insert(chunk.end(), checked.begin(), checked.end());
    appendBig(chunk, uint32_t(crc32(0, checked.data(), uInt(checked.size()))));
    MadeBytes out = png;
    out.insert(atEnd ? out.end() - 12 : out.begin() + 33, chunk.begin(), chunk.end());
    return out;
}

/** The chunk iCCP of a profile. */
inline MadeBytes profileChunk(const MadeBytes& profile) {
    MadeBytes data = {'p', 0, 0};
    MadeBytes packed(compressBound(uLong(profile.size())));
    uLongf bytes = uLongf(packed.size());
    compress(packed.data(), &bytes, profile.data(), uLong(profile.size()));
    data.insert(data.end(), packed.begin(), packed.begin() + std::ptrdiff_t(bytes));
    return data;
}

}  // namespace dpl
