// SPDX-License-Identifier: Apache-2.0
// What files of general splats state beside their numbers, and what the readers do with damaged or unusual splats. The files are made here.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "sdk/format/avatar_head.h"
#include "sdk/format/gltf_splats.h"
#include "sdk/format/ply.h"
#include "sdk/format/spz.h"
#include "tests/unit/format/glb_parts.h"
#include "tests/unit/format/splat_files.h"

namespace dpl {
namespace {

using namespace test;

Bytes bytesOf(const std::string& text) {
    return Bytes(text.begin(), text.end());
}

/** A good PLY with a change of its header. */
Bytes changedPly(const StaticSplatData& splats, const std::string& from, const std::string& to) {
    const Bytes good = *writePly(splats, {.normals = false});
    std::string text(good.begin(), good.end());
    const size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return bytesOf(text.replace(at, from.size(), to));
}
Bytes withComment(const StaticSplatData& splats, const std::string& comment) {
    return changedPly(splats, "element vertex", "comment " + comment + "\nelement vertex");
}

/** A splat as a renderer uses it: covariance and colour by direction. */
Mat3f covariance(const StaticSplatData& s, size_t i) {
    const Mat3f r = glm::mat3_cast(s.rotation[i]);
    const Vec3f v = s.scaleM[i] * s.scaleM[i];
    return r * Mat3f(v.x, 0, 0, 0, v.y, 0, 0, 0, v.z) * glm::transpose(r);
}

/** Expects `is` to be `was` turned or mirrored by `to`, in all that is drawn. */
void expectTurned(const StaticSplatData& is, const StaticSplatData& was, const Mat3f& to, float tolerance, const std::string& what) {
    ASSERT_EQ(is.count(), was.count()) << what;
    const size_t floats = shCoefficientCount(was.shDegree) * 3;
    for (size_t i = 0; i < was.count(); ++i) {
        EXPECT_LE(glm::length(is.position[i] - to * was.position[i]), tolerance) << what;
        const Mat3f wanted = to * covariance(was, i) * glm::transpose(to), found = covariance(is, i);
        for (int c = 0; c < 3; ++c) EXPECT_LE(glm::length(found[c] - wanted[c]), tolerance * 0.01f) << what;
        for (const Vec3f& d : {Vec3f(0.6f, 0, 0.8f), Vec3f(0, -0.8f, 0.6f), Vec3f(-0.48f, 0.6f, -0.64f)})
            EXPECT_LE(glm::length(shColour(&is.sh[i * floats], is.shDegree, to * d) - shColour(&was.sh[i * floats], was.shDegree, d)),
                      tolerance)
                << what << " splat " << i;
    }
}

TEST(SplatStatements, plyCommentsNameTheUpAxis) {
    const struct {
        const char* comment;
        Vec3f up;  // in the file; zero: not stated
    } table[] = {{"Vertical axis: y", {0, 1, 0}},
                 {"Vertical Axis: z", {0, 0, 1}},        // nerfstudio
                 {"Vertical axis: 0 -1 0", {0, -1, 0}},  // Brush
                 {"vertical axis: 0.0, -1.0, 0.0", {0, -1, 0}},
                 {"Vertical axis: -y", {0, -1, 0}},
                 {"Vertical axis: +Z", {0, 0, 1}},
                 {"Vertical axis: -z", {0, 0, -1}},
                 {"Vertical axis: x", {1, 0, 0}},
                 {"Vertical axis: y-down", {0, -1, 0}},
                 {"Vertical axis: z up", {0, 0, 1}},
                 {"Vertical axis: 0.1 -0.97 0.2", glm::normalize(Vec3f(0.1f, -0.97f, 0.2f))},
                 {"Vertical axis: 0 -3 0", {0, -1, 0}},
                 {"Vertical axis: banana", {0, 0, 0}},
                 {"Vertical axis: 0 0 0", {0, 0, 0}},
                 {"Vertical axis: nan nan nan", {0, 0, 0}},
                 {"Vertical axis:", {0, 0, 0}},
                 {"SH degree: 3", {0, 0, 0}}};
    const StaticSplatData was = pinnedSplats();
    for (const auto& [comment, up] : table) {
        const Bytes bytes = withComment(was, comment);
        auto file = readSplats(bytes);
        ASSERT_TRUE(file) << comment << ": " << file.error().message;
        const bool stated = up != Vec3f(0);
        EXPECT_EQ(!file->remarks.axes.stated.empty(), stated) << comment;
        const Mat3f turn(file->remarks.axes.uprightFromFile);
        if (stated)
            EXPECT_LE(glm::length(turn * up - Vec3f(0, 1, 0)), 1e-6f) << comment << ": up must become y";
        else
            EXPECT_EQ(turn, Mat3f(1)) << comment << ": nothing is guessed";
        EXPECT_NEAR(glm::determinant(turn), 1, 1e-6f) << comment;
        expectTurned(file->splats, was, turn, 2e-5f, comment);
        const bool understood = stated || std::string(comment).find("axis") == std::string::npos;
        EXPECT_EQ(file->remarks.notes.empty(), understood) << comment << ": what is not understood is said";
    }
}

TEST(SplatStatements, compressedPlyHearsCommentsToo) {
    CompressedPlyByHand f;
    f.words[0] = {0xffffffff, 512u << 20 | 512u << 10 | 1023u, 0xffffffff, 0xff8000ff};
    const Bytes plain = f.bytes();
    std::string text(plain.begin(), plain.end());
    text.replace(text.find("comment by hand"), 15, "comment Vertical axis: 0 -1 0\ncomment SplatRenderMode: mip");
    auto was = readSplats(plain), is = readSplats(bytesOf(text));
    ASSERT_TRUE(was && is);
    EXPECT_TRUE(was->remarks.axes.stated.empty());
    EXPECT_FALSE(was->splats.compensated);
    EXPECT_TRUE(is->splats.compensated);
    expectTurned(is->splats, was->splats, Mat3f(1, 0, 0, 0, -1, 0, 0, 0, -1), 2e-5f, "compressed");
}

TEST(SplatStatements, plyCommentsSayAntialiased) {
    const std::pair<const char*, bool> table[] = {{"SplatRenderMode: mip", true},
                                                  {"SplatRenderMode: default", false},
                                                  {"  SPLATRENDERMODE:  MIP  ", true},
                                                  {"antialiased 1", true},
                                                  {"antialiased 0", false},
                                                  {"antialiasedness 1", false},
                                                  {"SplatRenderMode: mipmap", false},
                                                  {"Exported from Brush", false}};
    for (const auto& [comment, antialiased] : table) {
        auto file = readSplats(withComment(ofDegree(0), comment));
        ASSERT_TRUE(file) << comment;
        EXPECT_EQ(file->splats.compensated, antialiased) << comment;
        auto again = readSplats(*writePly(file->splats, {.axes = "LDB"}));
        ASSERT_TRUE(again);
        EXPECT_EQ(again->splats.compensated, antialiased) << comment << ": kept on writing";
    }
}

/** The sixteen systems of the extension: the directions of x, y and z in our axes. */
TEST(SplatStatements, spzExtensionNamesTheCoordinates) {
    const char* systems[] = {"RUB", "LDB", "RDB", "LUB", "RUB", "LDF", "RDF", "LUF", "RUF",
                             "LFD", "RFD", "LFU", "RFU", "LBD", "RBD", "LBU", "RBU"};  // 0: not specified
    const auto directionOf = [](char letter) {
        return letter == 'R'   ? Vec3f(1, 0, 0)
               : letter == 'L' ? Vec3f(-1, 0, 0)
               : letter == 'U' ? Vec3f(0, 1, 0)
               : letter == 'D' ? Vec3f(0, -1, 0)
               : letter == 'B' ? Vec3f(0, 0, 1)
                               : Vec3f(0, 0, -1);
    };
    const Bytes plain = *writeSpz(pinnedSplats());
    const StaticSplatData was = readSplats(plain)->splats;
    const auto withRecords = [&](const Bytes& records) {
        Bytes bytes = plain;
        const uint32_t tableAt = uint32_t(32 + records.size());
        std::memcpy(&bytes[16], &tableAt, 4), bytes[14] |= 2;
        bytes.insert(bytes.begin() + 32, records.begin(), records.end());
        return bytes;
    };
    for (uint32_t system = 0; system < 17; ++system) {
        Bytes records;
        append(records, 0xadbe0002u), append(records, 12u), records.insert(records.end(), 12, uint8_t(0));  // another extension before it
        append(records, 0xadbe0003u), append(records, 4u), append(records, system);
        const Bytes bytes = withRecords(records);
        auto file = readSplats(bytes);
        ASSERT_TRUE(file) << system << ": " << file.error().message;
        Mat3f to;
        for (int k = 0; k < 3; ++k) to[k] = directionOf(systems[system][k]);
        EXPECT_EQ(Mat3f(file->remarks.axes.uprightFromFile), to) << system;
        expectTurned(file->splats, was, to, 2e-5f, systems[system]);
        EXPECT_TRUE(file->remarks.notes.empty());
    }
    Bytes unknown, cut;
    append(unknown, 0xadbe0003u), append(unknown, 4u), append(unknown, 99u);
    append(cut, 0xadbe0003u), append(cut, 400u), append(cut, 6u);
    auto strange = readSplats(withRecords(unknown)), short_ = readSplats(withRecords(cut));
    ASSERT_TRUE(strange && short_);
    EXPECT_EQ(strange->splats.position, was.position);
    ASSERT_EQ(strange->remarks.notes.size(), 1u);
    EXPECT_NE(strange->remarks.notes[0].find("coordinate system 99"), std::string::npos);
    EXPECT_EQ(short_->splats.position, was.position);
}

/** Mip-Splatting's filter with one, two or three different scales, in the column's two spellings. */
TEST(SplatStatements, filter3DIsFused) {
    for (const char* name : {"filter_3D", "filter_3d"}) {
        StaticSplatData s = ofDegree(0);
        s.rotation.assign(s.count(), Quatf(1, 0, 0, 0));
        const Bytes plain = *writePly(s, {.normals = false});
        const size_t row = 14 * 4, body = plain.size() - s.count() * row;
        const double filterM = 0.05;
        std::string header(plain.begin(), plain.begin() + ptrdiff_t(body));
        header.replace(header.find("end_header"), 10, std::string("property float ") + name + "\nend_header");
        Bytes bytes = bytesOf(header);
        for (size_t i = 0; i < s.count(); ++i) {
            bytes.insert(bytes.end(), plain.begin() + ptrdiff_t(body + i * row), plain.begin() + ptrdiff_t(body + (i + 1) * row));
            append(bytes, float(filterM));
        }
        auto file = readSplats(bytes);
        ASSERT_TRUE(file) << file.error().message;
        for (size_t i = 0; i < s.count(); ++i) {
            double before = 1, after = 1;
            for (int k = 0; k < 3; ++k) {
                const double squared = double(s.scaleM[i][k]) * s.scaleM[i][k];
                before *= squared, after *= squared + filterM * filterM;
                EXPECT_NEAR(file->splats.scaleM[i][k], std::sqrt(squared + filterM * filterM), 1e-6) << i;
            }
            EXPECT_NEAR(file->splats.opacity[i], s.opacity[i] * std::sqrt(before / after), 1e-6) << i;
        }
        ASSERT_EQ(file->remarks.notes.size(), 1u);
        EXPECT_NE(file->remarks.notes[0].find("filter_3D"), std::string::npos);
    }
}

TEST(SplatStatements, twoScalesAreFlatSplats) {
    StaticSplatData s = ofDegree(1);
    const Bytes plain = *writePly(s, {.normals = false});
    const size_t row = (14 + 9) * 4, body = plain.size() - s.count() * row, third = (3 + 3 + 9 + 1 + 2) * 4;
    std::string header(plain.begin(), plain.begin() + ptrdiff_t(body));
    header.replace(header.find("property float scale_2\n"), 23, "");
    Bytes bytes = bytesOf(header);
    for (size_t i = 0; i < s.count(); ++i) {
        const auto at = plain.begin() + ptrdiff_t(body + i * row);
        bytes.insert(bytes.end(), at, at + third), bytes.insert(bytes.end(), at + third + 4, at + row);
    }
    auto file = readSplats(bytes);
    ASSERT_TRUE(file) << file.error().message;
    ASSERT_EQ(file->splats.count(), s.count());
    for (size_t i = 0; i < s.count(); ++i) {
        const Vec3f &is = file->splats.scaleM[i], &was = s.scaleM[i];
        EXPECT_NEAR(is.x, was.x, 1e-6f);
        EXPECT_NEAR(is.y, was.y, 1e-6f);
        EXPECT_LE(is.z, 0.01f * std::min(was.x, was.y)) << "flat";
        EXPECT_NEAR(file->splats.opacity[i], s.opacity[i], 1e-6f);
        EXPECT_GE(std::abs(glm::dot(file->splats.rotation[i], s.rotation[i])), 1 - 1e-6f);
    }
    EXPECT_EQ(file->remarks.notes.size(), 1u);
}

TEST(SplatStatements, splatsThatAreNotFiniteAreLeftOutAndCounted) {
    const StaticSplatData s = ofDegree(1);
    const Bytes good = *writePly(s, {.normals = false});
    const size_t columns = 14 + 9, body = good.size() - s.count() * columns * 4;
    for (size_t column = 0; column < columns; ++column)
        for (const size_t splat : {size_t(0), size_t(3), size_t(s.count() - 1)}) {
            Bytes bytes = good;
            const float nan = NAN;
            std::memcpy(&bytes[body + (splat * columns + column) * 4], &nan, 4);
            auto file = readSplats(bytes);
            ASSERT_TRUE(file) << column << ": " << file.error().message;
            StaticSplatData rest = readSplats(good)->splats;
            const auto drop = [&](auto& list, size_t floats) {
                list.erase(list.begin() + ptrdiff_t(splat * floats), list.begin() + ptrdiff_t((splat + 1) * floats));
            };
            drop(rest.position, 1), drop(rest.sh, 12), drop(rest.opacity, 1);
            EXPECT_EQ(file->splats.position, rest.position) << column;
            EXPECT_EQ(file->splats.sh, rest.sh) << column;
            EXPECT_EQ(file->splats.opacity, rest.opacity) << column;
            EXPECT_EQ(file->remarks.dropped, 1u);
            ASSERT_EQ(file->remarks.notes.size(), 1u);
            EXPECT_NE(file->remarks.notes[0].find("1 of 7 splats left out"), std::string::npos) << file->remarks.notes[0];
        }
    Bytes none = good;
    for (size_t at = body; at < none.size(); at += 4) std::memset(&none[at], 0xff, 4);  // NaN
    expectRefused(readSplats(none), "nothing but NaN", Code::CorruptData, "none of its 7 splats is finite");
}

TEST(SplatStatements, compressedAndGltfSplatsThatAreNotFiniteAreLeftOut) {
    CompressedPlyByHand f;
    f.ranges[1][4] = NAN;  // of the chunk of the last 44 splats
    auto file = readSplats(f.bytes());
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_EQ(file->splats.count(), 256u);
    EXPECT_EQ(file->remarks.dropped, 44u);
    f.ranges[0][4] = NAN;
    expectRefused(readSplats(f.bytes()), "both chunks", Code::CorruptData, "none of its 300");

    const StaticSplatData s = ofDegree(1);
    for (const char* attribute : {"POSITION", "KHR_gaussian_splatting:ROTATION", "KHR_gaussian_splatting:SCALE",
                                  "KHR_gaussian_splatting:OPACITY", "KHR_gaussian_splatting:SH_DEGREE_1_COEF_2"}) {
        auto parts = split(*writeGltfSplats(s));
        const size_t accessor = parts.json["meshes"][0]["primitives"][0]["attributes"][attribute];
        const size_t floats = parts.accessor(accessor).size() / 4 / s.count();
        const float nan = NAN;
        std::memcpy(parts.accessor(accessor).data() + 2 * floats * 4, &nan, 4);  // of the third splat
        auto read = readSplats(parts.bytes());
        ASSERT_TRUE(read) << attribute << ": " << read.error().message;
        ASSERT_EQ(read->splats.count(), 6u) << attribute;
        EXPECT_EQ(read->remarks.dropped, 1u);
        EXPECT_EQ(read->splats.position[1], s.position[1]);
        EXPECT_EQ(read->splats.position[2], s.position[3]);
        EXPECT_EQ(read->splats.sh[2 * 12 + 5], s.sh[3 * 12 + 5]);
    }
}

TEST(SplatStatements, aMessageStatesWhatWasFound) {
    const StaticSplatData s = ofDegree(0);
    for (const char* type : {"double", "half", "uchar", "int"})
        for (const char* name : {"x", "f_dc_1", "opacity", "scale_2", "rot_3"}) {
            const std::string column = std::string("float ") + name + "\n";
            Bytes bytes = changedPly(s, column, std::string(type) + " " + name + "\n");
            bytes.resize(bytes.size() + 100);  // so that longer rows fit
            auto file = readSplats(bytes);
            ASSERT_FALSE(file) << type << name;
            const std::string& text = file.error().message;
            EXPECT_EQ(text.find("Gaussian splat file?"), std::string::npos) << text;
            EXPECT_NE(text.find(type == std::string("half") ? "unknown type half" : std::string("is a ") + type), std::string::npos)
                << text;
        }
    auto points = readSplats(changedPly(s, "float f_dc_0", "float red"));
    expectRefused(points, "a point cloud", Code::CorruptData, "point cloud");
    constexpr std::string_view kText = "\xef\xbb\xbf{\"asset\": {\"version\": \"2.0\"}}";
    for (const std::string_view text : {kText, kText.substr(3)}) {
        const Status said = checkAvatarHead({reinterpret_cast<const uint8_t*>(text.data()), text.size()}, text.size());
        ASSERT_FALSE(said);
        EXPECT_NE(said.error().message.find("convert it to a .glb"), std::string::npos) << said.error().message;
    }
}

/** Bands above 3 are dropped from a PLY of any complete degree, with a note; the lower ones are those of each colour. */
TEST(SplatStatements, higherShDegreesAreDrawnUpToThree) {
    StaticSplatData s = pinnedSplats();
    const Bytes plain = *writePly(s, {.normals = false});
    const size_t row = (14 + 45) * 4, body = plain.size() - s.count() * row, restAt = 6 * 4;
    for (const size_t perChannel : {size_t(24), size_t(35)}) {
        std::string header(plain.begin(), plain.begin() + ptrdiff_t(body));
        std::string more;
        for (size_t k = 45; k < perChannel * 3; ++k) more += "property float f_rest_" + std::to_string(k) + "\n";
        header.insert(header.find("property float opacity"), more);
        Bytes bytes = bytesOf(header);
        for (size_t i = 0; i < s.count(); ++i) {
            const auto at = plain.begin() + ptrdiff_t(body + i * row);
            bytes.insert(bytes.end(), at, at + restAt);
            for (ptrdiff_t channel = 0; channel < 3; ++channel) {
                bytes.insert(bytes.end(), at + restAt + channel * 60, at + restAt + (channel + 1) * 60);
                for (size_t k = 15; k < perChannel; ++k) append(bytes, 9.0f);
            }
            bytes.insert(bytes.end(), at + restAt + 180, at + row);
        }
        auto file = readSplats(bytes);
        ASSERT_TRUE(file) << file.error().message;
        EXPECT_EQ(file->splats.shDegree, 3u);
        EXPECT_EQ(file->remarks.shDegree, perChannel == 24 ? 4u : 5u);
        EXPECT_EQ(file->splats.sh, s.sh);
        ASSERT_EQ(file->remarks.notes.size(), 1u);
        EXPECT_NE(file->remarks.notes[0].find("drawn up to degree 3"), std::string::npos);
    }
}

TEST(SplatStatements, mapCoordinatesAreRefusedWithTheRemedy) {
    const auto moved = [](Vec3f by, float sizeM) {
        StaticSplatData s = ofDegree(0);
        for (Vec3f& p : s.position) p += by;
        s.scaleM.assign(s.count(), Vec3f(sizeM));
        return readSplats(*writePly(s));
    };
    expectRefused(moved({448250, 5411951, 300}, 0.02f), "UTM", Code::CorruptData, "subtract a local origin");
    expectRefused(moved({-2.5e6f, 4.6e6f, 3.6e6f}, 0.02f), "geocentric", Code::CorruptData, "subtract a local origin");
    auto coarse = moved({50000, 0, 0}, 0.02f), fine = moved({500, 20, -300}, 0.02f), wide = moved({448250, 5411951, 300}, 50);
    ASSERT_TRUE(coarse && fine && wide);
    ASSERT_EQ(coarse->remarks.notes.size(), 1u);
    EXPECT_NE(coarse->remarks.notes[0].find("subtract a local origin"), std::string::npos);
    EXPECT_TRUE(fine->remarks.notes.empty());
    EXPECT_TRUE(wide->remarks.notes.empty()) << "splats of 50 m stand well enough there";
}

TEST(SplatStatements, ownPlysComeBackAsTheyWent) {
    const StaticSplatData want = pinnedSplats();
    const Bytes half = *writePly(want, {.axes = "LDB"}), up = *writePly(want, {.axes = "RUB"});
    const std::string text(half.begin(), half.end());
    EXPECT_NE(text.find("comment Vertical axis: 0 -1 0\n"), std::string::npos);
    EXPECT_NE(text.find("comment Doppel axes: x left, y down, z back\n"), std::string::npos);
    const StaticSplatData raw = *readPly(half);
    expectTurned(raw, want, Mat3f(-1, 0, 0, 0, -1, 0, 0, 0, 1), 2e-5f, "half a turn about z");
    for (const char* axes : {"LDB", "RUB", "RDF", "RFU", "LUB"}) {
        const Bytes first = *writePly(want, {.axes = axes});
        auto file = readSplats(first);
        ASSERT_TRUE(file) << file.error().message;
        EXPECT_TRUE(file->remarks.notes.empty());
        expectTurned(file->splats, want, Mat3f(1), 2e-5f, axes);
        if (axes == std::string("RFU")) continue;  // a quarter turn rounds
        EXPECT_EQ(file->splats.position, want.position) << axes;
        EXPECT_EQ(file->splats.sh, want.sh) << axes;
        EXPECT_EQ(*writePly(file->splats, {.axes = axes}),
                  *writePly(readSplats(*writePly(file->splats, {.axes = axes}))->splats, {.axes = axes}))
            << axes << ": the bytes settle";
    }
    EXPECT_FALSE(writePly(want, {.axes = "XYZ"}));
    EXPECT_FALSE(writePly(want, {.axes = "RLB"})) << "right and left are one axis";
    EXPECT_EQ(std::string(up.begin(), up.end()).find("0 1 0") != std::string::npos, true);
}

/** Codes round to half a step, as for the files of the reference library. */
TEST(SplatStatements, ownSpzsComeBackAsTheyWent) {
    for (const uint32_t version : {3u, 4u})
        for (const uint32_t degree : {0u, 1u, 3u})
            for (const bool antialiased : {false, true}) {
                StaticSplatData want = ofDegree(degree);
                want.compensated = antialiased;
                auto bytes = writeSpz(want, version);
                ASSERT_TRUE(bytes) << bytes.error().message;
                auto file = readSplats(*bytes);
                ASSERT_TRUE(file) << file.error().message;
                EXPECT_EQ(file->version, version);
                EXPECT_EQ(file->splats.compensated, antialiased);
                expectSplats(file->splats, want, {0.00025f, 4e-6f, 0.033f, 0.0021f, 0.014f, 0.0041f});
                auto again = readSplats(*writeSpz(file->splats, version));
                ASSERT_TRUE(again);
                expectSplats(again->splats, file->splats, {1e-6f, 4e-6f, 1e-5f, 1e-6f, 1e-5f, 1e-6f});
            }
    const Bytes four = *writeSpz(pinnedSplats());
    EXPECT_EQ(four[14], 0) << "no antialiased mark, no extension";
    uint32_t tableAt;
    std::memcpy(&tableAt, &four[16], 4);
    EXPECT_EQ(tableAt, 32u) << "no coordinate extension";
    EXPECT_FALSE(writeSpz(pinnedSplats(), 2));
    EXPECT_FALSE(writeSpz({}, 4));
}

TEST(SplatStatements, spzKeepsPlacesOfSmallAndLargeScenes) {
    for (const float size : {0.001f, 0.02f, 1.0f, 900.0f, 100000.0f}) {
        StaticSplatData s = ofDegree(0);
        for (Vec3f& p : s.position) p *= size;
        for (Vec3f& scale : s.scaleM) scale = glm::max(scale * size, Vec3f(6e-5f));
        auto file = readSplats(*writeSpz(s));
        ASSERT_TRUE(file) << file.error().message;
        for (size_t i = 0; i < s.count(); ++i)
            EXPECT_LE(glm::length(file->splats.position[i] - s.position[i]), std::max(size * 0.0005f, size > 2000 ? 0.02f : 0.0f)) << size;
    }
    StaticSplatData far = ofDegree(0);
    far.position[0].x = 1e8f;
    auto refused = writeSpz(far);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find(".glb"), std::string::npos);
}

TEST(SplatStatements, damageInGltfIsSaid) {
    const auto changed = [](auto change) {
        auto parts = split(*writeGltfSplats(ofDegree(0)));
        change(parts.json);
        return readSplats(parts.bytes());
    };
    const char* nulls[] = {
        "/nodes/0/mesh",      "/nodes/0/scale",          "/nodes/0/translation/1",    "/meshes/0/primitives/0/mode",
        "/accessors/0/count", "/accessors/0/byteOffset", "/bufferViews/1/byteOffset", "/meshes/0/primitives/0/attributes/POSITION",
        "/accessors/0/max/1", "/accessors/1/normalized", "/bufferViews/0/byteStride"};
    for (const char* place : nulls) {
        auto file = changed([&](auto& json) {
            json["nodes"][0]["scale"] = {1, 1, 1}, json["nodes"][0]["translation"] = {0, 0, 0};
            json[nlohmann::json::json_pointer(place)] = nullptr;
        });
        ASSERT_FALSE(file) << place << " was accepted";
        EXPECT_EQ(int(file.error().code), int(Code::CorruptData)) << place;
    }
    expectRefused(changed([](auto& json) {
                      json["nodes"][0]["translation"] = {0, nullptr, 0};
                  }),
                  "a null", Code::CorruptData, "null at nodes/0/translation/1");
    for (const nlohmann::json& material : {nlohmann::json(7), nlohmann::json(0), nlohmann::json(-1), nlohmann::json(), nlohmann::json("a")})
        expectRefused(changed([&](auto& json) { json["meshes"][0]["primitives"][0]["material"] = material; }), "a material",
                      Code::CorruptData, "names material");
    EXPECT_TRUE(changed([](auto& json) { json["materials"] = {{{"name", "one"}}}, json["meshes"][0]["primitives"][0]["material"] = 0; }));
    expectRefused(changed([](auto& json) { json["accessors"][0]["max"][0] = 9e15; }), "a maximum of 9e15", Code::CorruptData, "damaged");
    const std::pair<const char*, double> bounds[] = {{"max", 700}, {"min", -9e9}, {"max", 0.0}, {"min", 3.0}};
    for (const auto& [key, value] : bounds) {
        auto file = changed([key = key, value = value](auto& json) { json["accessors"][0][key][0] = value; });
        ASSERT_TRUE(file) << file.error().message;
        ASSERT_EQ(file->remarks.notes.size(), 1u) << key << value;
        EXPECT_NE(file->remarks.notes[0].find("POSITION states values"), std::string::npos);
    }
    EXPECT_TRUE(changed([](auto&) {})->remarks.notes.empty());
    EXPECT_TRUE(changed([](auto& json) { json["accessors"][0]["max"][0] = 0.5004; })->remarks.notes.empty()) << "rounded by the writer";
}

TEST(SplatStatements, theBoxHoldsWhatIsSmall) {
    StaticSplatData one;
    one.position = {{1, 2, 3}}, one.scaleM = {{0.1f, 0.2f, 0.05f}};
    EXPECT_EQ(boxOf(one).low, Vec3f(1, 2, 3) - Vec3f(0.6f));
    EXPECT_EQ(boxOf(one).high, Vec3f(1, 2, 3) + Vec3f(0.6f));
    StaticSplatData wide;
    for (int i = 0; i < 100; ++i) wide.position.emplace_back(i, 0, 0), wide.scaleM.emplace_back(0.2f);
    EXPECT_EQ(boxOf(wide).low, Vec3f(1, 0, 0)) << "as before";
}

}  // namespace
}  // namespace dpl
