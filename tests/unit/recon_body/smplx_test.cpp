// SPDX-License-Identifier: Apache-2.0
// The SMPL-X importer on a synthetic .npz: a column of joints with a few vertices each. No real SMPL-X file is used.
#include "reconstruction/subject/body/smplx.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>

#include "reconstruction/base/npz.h"
#include "reconstruction/subject/body/body_tools.h"
#include "sdk/core/writer.h"
#include "tests/unit/made_zip.h"

namespace dpl {
namespace {

template <class T>
std::vector<uint8_t> npy(const std::string& type, const std::string& shape, const std::vector<T>& values) {
    std::string header = "{'descr': '" + type + "', 'fortran_order': False, 'shape': " + shape + ", }";
    while ((10 + header.size() + 1) % 64) header.push_back(' ');
    header.push_back('\n');
    Writer out;
    for (uint8_t b : {0x93, 0x4E, 0x55, 0x4D, 0x50, 0x59, 0x01, 0x00}) out.value(b);
    out.value(uint16_t(header.size()));
    out.append({reinterpret_cast<const uint8_t*>(header.data()), header.size()});
    out.append({reinterpret_cast<const uint8_t*>(values.data()), values.size() * sizeof(T)});
    return out.finish();
}

constexpr size_t kJoints = 55, kPerJoint = 4, kVertices = kJoints * kPerJoint;
constexpr int kParents[kJoints] = {-1, 0,  0,  0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  9,  9,  12, 13, 14, 16,
                                   17, 18, 19, 15, 15, 15, 20, 25, 26, 20, 28, 29, 20, 31, 32, 20, 34, 35, 20,
                                   37, 38, 21, 40, 41, 21, 43, 44, 21, 46, 47, 21, 49, 50, 21, 52, 53};

std::vector<std::pair<std::string, std::vector<uint8_t>>> smplxEntries() {
    std::vector<double> vertices, shapeDirs, regressor(kJoints * kVertices, 0.0), weights(kVertices * kJoints, 0.0);
    std::vector<uint32_t> faces;
    std::vector<int64_t> tree;
    for (size_t v = 0; v < kVertices; ++v) {
        const size_t j = v / kPerJoint, corner = v % kPerJoint;
        const double p[3] = {0.02 * double(corner == 1) + 0.01 * double(j % 3), -0.8 + 0.03 * double(j) + 0.02 * double(corner == 2),
                             0.02 * double(corner == 3)};
        for (double x : p) {
            vertices.push_back(x);
            shapeDirs.push_back(0.1 * x), shapeDirs.push_back(0.5), shapeDirs.push_back(-1);
        }
        regressor[j * kVertices + v] = 1.0 / kPerJoint;
        weights[v * kJoints + j] = 0.7;
        for (size_t other = 1; other < 6; ++other)
            weights[v * kJoints + (j + other) % kJoints] = 0.06;  // six influences: two must be dropped
    }
    for (size_t j = 0; j < kJoints; ++j) {
        const uint32_t f = uint32_t(kPerJoint * j);
        faces.insert(faces.end(), {f, f + 1, f + 2, f, f + 2, f + 3});
        tree.push_back(j == 0 ? int64_t(4294967295) : int64_t(kParents[j]));
    }
    for (size_t j = 0; j < kJoints; ++j) tree.push_back(int64_t(j));
    return {
        {"v_template.npy", npy("<f8", "(220, 3)", vertices)},
        {"shapedirs.npy", npy("<f8", "(220, 3, 3)", shapeDirs)},
        {"J_regressor.npy", npy("<f8", "(55, 220)", regressor)},
        {"weights.npy", npy("<f8", "(220, 55)", weights)},
        {"kintree_table.npy", npy("<i8", "(2, 55)", tree)},
        {"f.npy", npy("<u4", "(110, 3)", faces)},
        {"joint2num.npy", npy("|O", "()", std::vector<uint8_t>(40, 7))}};  // real files hold such pickles; the importer must ignore them
}

std::filesystem::path save(const char* name, const std::vector<uint8_t>& bytes) {
    const auto path = std::filesystem::path(testing::TempDir()) / name;
    std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
    return path;
}

TEST(Smplx, importsShapeSkeletonAndSkin) {
    const auto body = importSmplx(save("made_smplx.npz", zip(smplxEntries())), {.shapeCount = 2});
    ASSERT_TRUE(body) << body.error().message;
    EXPECT_EQ(body->joints.size(), kJoints);
    EXPECT_EQ(body->joints[18].name, "left_elbow");
    EXPECT_EQ(body->joints[18].humanoidBone, "leftLowerArm");
    EXPECT_EQ(body->joints[0].parent, -1);
    ASSERT_EQ(body->morphs.size(), 2u);
    float low = 1;
    for (const Vec3f& p : body->mesh.restPositions) low = std::min(low, p.y);
    EXPECT_NEAR(low, 0, 1e-6);
    // Morph 0 moves a vertex by a tenth of its position before the lift to y = 0; joints follow through the regressor.
    EXPECT_NEAR(body->morphs[0].jointOffsets[10].y, 0.1 * (-0.8 + 0.3 + 0.005), 1e-6);
    EXPECT_NEAR(body->morphs[1].vertexOffsets[5].x, 0.5, 1e-6);
    for (const glm::u8vec4& w : body->mesh.jointWeights) EXPECT_EQ(w.x + w.y + w.z + w.w, 255);
    EXPECT_EQ(body->mesh.jointIndices[0].x, 0);
}

TEST(Smplx, everyDamageIsASentenceThatNamesTheFile) {
    const auto good = zip(smplxEntries());
    for (size_t length = 0; length < good.size(); length += good.size() / 61) {
        const auto body = importSmplx(save("cut.npz", {good.begin(), good.begin() + std::ptrdiff_t(length)}));
        ASSERT_FALSE(body) << length;
        EXPECT_NE(body.error().message.find("cut.npz"), std::string::npos);
    }
    auto entries = smplxEntries();
    entries.erase(entries.begin() + 3);
    const auto body = importSmplx(save("partial.npz", zip(entries)));
    ASSERT_FALSE(body);
    EXPECT_NE(body.error().message.find("weights"), std::string::npos);
}

TEST(Npy, refusesWhatItCannotRead) {
    EXPECT_TRUE(parseNpy(npy("<f4", "(2,)", std::vector<float>{1, 2})));
    EXPECT_FALSE(parseNpy(npy("<f4", "(3,)", std::vector<float>{1, 2})));                     // shape larger than the data
    EXPECT_FALSE(parseNpy(npy("<f4", "(99999999999, 99999999999)", std::vector<float>{1})));  // overflow
    EXPECT_FALSE(parseNpy(npy("|O", "(1,)", std::vector<uint8_t>{0, 0, 0, 0, 0, 0, 0, 0})));  // a pickle
    EXPECT_FALSE(parseNpy(npy(">f4", "(1,)", std::vector<float>{1})));                        // big endian
}

TEST(Npz, smallArchivesCannotUnpackToGigabytes) {
    // 300 MB of zeros, as 16-bit numbers that would become 1.2 GB of doubles, in about 300 KB.
    const auto bomb = zip({{"a.npy", npy("<i2", "(150000000,)", std::vector<int16_t>(150000000, 0))}});
    ASSERT_LT(bomb.size(), 1u << 20);
    auto npz = NpzFile::open(bomb);
    ASSERT_TRUE(npz) << npz.error().message;
    const auto array = npz->read("a");
    ASSERT_FALSE(array);
    EXPECT_NE(array.error().message.find("more than an archive of this size may hold"), std::string::npos) << array.error().message;

    // Each array alone is small enough, all together are not: 64 MiB and 64 times the archive are shared.
    std::vector<std::pair<std::string, std::vector<uint8_t>>> entries;
    for (char c = 'a'; c < 'i'; ++c) {
        entries.emplace_back(std::string(1, c) + ".npy", npy("<i2", "(2000000,)", std::vector<int16_t>(2000000, 0)));
        entries.emplace_back(std::string(1, c) + ".txt", std::vector<uint8_t>{'x'});  // zip() stores every other entry without deflate
    }
    const auto many = zip(entries);
    auto shared = NpzFile::open(many);
    ASSERT_TRUE(shared);
    EXPECT_TRUE(shared->read("a"));
    size_t taken = 1;
    for (char c = 'b'; c < 'i'; ++c) taken += bool(shared->read(std::string(1, c)));
    EXPECT_LT(taken * 16000000, (64u << 20) + 64 * many.size());
    EXPECT_LT(taken, 8u);
}

}  // namespace
}  // namespace dpl
