// SPDX-License-Identifier: Apache-2.0
// Damage that a file itself shows is said: checksums of archives, and numbers that are null.
#include <gtest/gtest.h>

#include "reconstruction/base/json_fields.h"
#include "reconstruction/base/npz.h"
#include "tests/unit/made_zip.h"
#include "tests/unit/must.h"

namespace dpl {
namespace {

std::vector<uint8_t> npyOf(const std::vector<double>& values) {
    std::string header = formatText("{'descr': '<f8', 'fortran_order': False, 'shape': ({},), }", values.size());
    header.resize(117, ' ');
    header += '\n';
    std::vector<uint8_t> file = {0x93, 'N', 'U', 'M', 'P', 'Y', 1, 0, uint8_t(header.size()), 0};
    file.insert(file.end(), header.begin(), header.end());
    const auto* bytes = reinterpret_cast<const uint8_t*>(values.data());
    file.insert(file.end(), bytes, bytes + values.size() * 8);
    return file;
}

TEST(DamagedFiles, anArrayWithAWrongChecksumIsNotRead) {
    const std::vector<double> values = {1.5, -2, 3};
    const auto good = zip({{"packed.npy", npyOf(values)}, {"stored.npy", npyOf(values)}});
    auto file = must(NpzFile::open(good));
    EXPECT_EQ(must(file.read("packed")).values, values);
    EXPECT_EQ(must(file.read("stored")).values, values);
    // One bit of a stored number, and one of the checksum in the directory.
    auto bad = good;
    const std::vector<uint8_t> name = {'s', 't', 'o', 'r', 'e', 'd', '.', 'n', 'p', 'y'};
    const auto at = std::search(bad.begin(), bad.end(), name.begin(), name.end());
    at[long(name.size()) + 10 + 118 + 6] ^= 1;
    auto damaged = must(NpzFile::open(bad));
    EXPECT_TRUE(damaged.read("packed"));
    const auto refused = damaged.read("stored");
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, Code::CorruptData);
    EXPECT_NE(refused.error().message.find("'stored.npy' is damaged: its checksum is wrong"), std::string::npos) << refused.error().message;
    bad = good;
    const std::vector<uint8_t> entry = {0x50, 0x4b, 0x01, 0x02};
    std::search(bad.begin(), bad.end(), entry.begin(), entry.end())[16] ^= 1;
    EXPECT_FALSE(must(NpzFile::open(bad)).read("packed"));
}

TEST(DamagedFiles, nullIsNoNumber) {
    const auto object = nlohmann::json::parse(R"({"k1": null, "list": [1, null], "metric": null, "k2": 0.5})");
    const JsonFields fields(object, "transforms.json");
    for (const auto& read : {fields.number("k1"), fields.number("k1", 7)}) {
        ASSERT_FALSE(read);
        EXPECT_NE(read.error().message.find("'k1' is null, not a finite number"), std::string::npos) << read.error().message;
    }
    EXPECT_FALSE(fields.numbers("list", 2));
    EXPECT_EQ(must(fields.number("absent", 7)), 7);
    EXPECT_EQ(must(fields.number("k2", 7)), 0.5);
    EXPECT_FALSE(fields.has("metric")) << "for texts and truth values null is absence";
    EXPECT_TRUE(must(fields.boolean("metric", true)));
}

TEST(DamagedFiles, aFlagIsHeardInAnyForm) {
    const auto object = nlohmann::json::parse(R"({"a": true, "b": 1, "c": "true", "d": false, "e": 0, "f": "false", "g": null, "h": ""})");
    const JsonFields fields(object, "transforms.json");
    for (const char* key : {"a", "b", "c"}) EXPECT_TRUE(fields.states(key)) << key;
    for (const char* key : {"d", "e", "f", "g", "h", "absent"}) EXPECT_FALSE(fields.states(key)) << key;
}

}  // namespace
}  // namespace dpl
