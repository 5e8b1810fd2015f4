// SPDX-License-Identifier: Apache-2.0
// EXIF orientation and focal length, in both byte orders, and from damaged data.
#include "reconstruction/input/import/exif.h"

#include "tests/unit/recon_import/made_captures.h"

namespace dpl {
namespace {

const std::vector<uint8_t>& plainJpeg() {
    static const std::vector<uint8_t> jpeg = jpegOf(spotPicture(16, 8, {4, 4}));
    return jpeg;
}

TEST(Exif, bothByteOrdersAreRead) {
    for (bool little : {true, false}) {
        const ExifFields fields = readExif(withExif(plainJpeg(), 6, 26, little));
        EXPECT_EQ(fields.orientation, 6);
        EXPECT_EQ(fields.focalLength35Mm, 26);
    }
}

TEST(Exif, missingAndWrongValuesGiveDefaults) {
    EXPECT_EQ(readExif(plainJpeg()).orientation, 1);
    EXPECT_EQ(readExif(withExif(plainJpeg(), 9, 0)).orientation, 1);
    EXPECT_EQ(readExif(withExif(plainJpeg(), 9, 0)).focalLength35Mm, 0);
    EXPECT_EQ(readExif({}).orientation, 1);
}

TEST(Exif, everyTruncationGivesDefaultsOrTheValues) {
    const auto whole = withExif(plainJpeg(), 6, 26);
    const size_t segmentEnd = whole.size() - plainJpeg().size() + 2;
    for (size_t length = 0; length < whole.size(); ++length) {
        const ExifFields fields = readExif({whole.data(), length});
        EXPECT_EQ(fields.orientation, length < segmentEnd ? 1 : 6) << length;
    }
}

TEST(Exif, everyFlippedByteStaysInRange) {
    auto bytes = withExif(plainJpeg(), 6, 26);
    for (size_t i = 0; i < 100; ++i)
        for (uint8_t value : {0x00, 0x7f, 0x80, 0xff}) {
            const uint8_t before = std::exchange(bytes[i], value);
            const ExifFields fields = readExif(bytes);
            EXPECT_TRUE(fields.orientation >= 1 && fields.orientation <= 8);
            EXPECT_TRUE(fields.focalLength35Mm == 0 || (fields.focalLength35Mm >= 5 && fields.focalLength35Mm <= 1000));
            bytes[i] = before;
        }
}

TEST(Exif, focalLengthComparesDiagonals) {
    EXPECT_NEAR(focalFrom35Mm(36, 3600, 2400), 3600, 1e-9);  // the shape of 35 mm film: 36 mm on 36 mm
    EXPECT_NEAR(focalFrom35Mm(26, 3024, 4032), focalFrom35Mm(26, 4032, 3024), 1e-9);
}

}  // namespace
}  // namespace dpl
