// SPDX-License-Identifier: Apache-2.0
#include "sdk/core/numbers.h"
#include "sdk/core/result.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <bit>
#include <clocale>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <string>

namespace {

using namespace dpl;

/** The number that `text` spells; NaN if it is refused. */
template <class T = double>
T numberIn(std::string_view text) {
    T value = std::numeric_limits<T>::quiet_NaN();
    return readNumber(text, value) ? value : std::numeric_limits<T>::quiet_NaN();
}

#if defined(_WIN32)
/** Selects a locale with a decimal comma, if the system has it. */
class DecimalComma {
public:
    DecimalComma() { active_ = std::setlocale(LC_NUMERIC, "German") && std::strtod("1,5", nullptr) == 1.5; }
    ~DecimalComma() { std::setlocale(LC_NUMERIC, "C"); }
    bool active() const { return active_; }

private:
    bool active_ = false;
};
#else
/** Writes a locale with nothing but a decimal comma in glibc's binary form, and selects it. Inactive where the C library is another one. */
class DecimalComma {
public:
    DecimalComma() : folder_(std::filesystem::temp_directory_path() / ("doppel_locale_" + std::to_string(::getpid()))) {
        std::filesystem::create_directories(folder_ / "comma");
        const uint32_t words[] = {0x20031115u ^ 1, 6, 32, 34, 35, 36, 40, 44, /*32: ",", "", "" */ ',', ',', 0};
        std::string bytes(reinterpret_cast<const char*>(words), sizeof words);
        bytes += std::string("UTF-8", 6);
        std::ofstream(folder_ / "comma" / "LC_NUMERIC", std::ios::binary) << bytes;
        ::setenv("LOCPATH", folder_.c_str(), 1);
        active_ = std::setlocale(LC_NUMERIC, "comma") && std::strtod("1,5", nullptr) == 1.5;
    }
    ~DecimalComma() {
        std::setlocale(LC_NUMERIC, "C");
        ::unsetenv("LOCPATH");
        std::filesystem::remove_all(folder_);
    }
    bool active() const { return active_; }

private:
    std::filesystem::path folder_;
    bool active_ = false;
};
#endif

TEST(Numbers, readsDecimalsWithAndWithoutPointAndExponent) {
    EXPECT_EQ(numberIn("0"), 0.0);
    EXPECT_EQ(numberIn("-12.5"), -12.5);
    EXPECT_EQ(numberIn("5."), 5.0);
    EXPECT_EQ(numberIn(".5"), 0.5);
    EXPECT_EQ(numberIn("1e3"), 1000.0);
    EXPECT_EQ(numberIn("-1.25E-2"), -0.0125);
    EXPECT_EQ(numberIn("1.5e+3"), 1500.0);
    EXPECT_EQ(numberIn("0007.50"), 7.5);
    EXPECT_TRUE(std::signbit(numberIn("-0.0")));
    EXPECT_EQ(numberIn<float>("0.1"), 0.1f);
}

TEST(Numbers, roundsToTheNearestDouble) {
    EXPECT_EQ(numberIn("0.1"), 0.1);
    EXPECT_EQ(numberIn("123456789012345678901234567890"), 123456789012345678901234567890.0);
    EXPECT_EQ(numberIn("9007199254740993"), 9007199254740992.0) << "a tie goes to the even neighbour";
    EXPECT_EQ(numberIn("9007199254740993.000000000000000000000000000000001"), 9007199254740994.0) << "just above that tie";
    std::mt19937_64 random(1);
    for (int i = 0; i < 20000; ++i) {
        const double value = std::bit_cast<double>(random());
        if (!std::isfinite(value)) continue;
        char text[64];
        std::snprintf(text, sizeof text, "%.17g", value);
        EXPECT_EQ(numberIn(text), value) << text;
    }
}

TEST(Numbers, readsTheSmallestAndTheLargest) {
    EXPECT_EQ(numberIn("4.9406564584124654e-324"), std::numeric_limits<double>::denorm_min());
    EXPECT_EQ(numberIn("2.2250738585072009e-308"), std::bit_cast<double>(uint64_t(0x000fffffffffffff))) << "the largest denormal";
    EXPECT_EQ(numberIn("1.7976931348623157e308"), std::numeric_limits<double>::max());
    EXPECT_EQ(numberIn("1e-310"), 1e-310);
    EXPECT_EQ(numberIn<float>("1e-45"), std::numeric_limits<float>::denorm_min());
    char text[1200];
    std::snprintf(text, sizeof text, "%.1074f", std::numeric_limits<double>::denorm_min());
    EXPECT_EQ(numberIn(text), std::numeric_limits<double>::denorm_min()) << "written out in full, 1076 characters";
    EXPECT_EQ(numberIn("0." + std::string(400, '0') + "1e401"), 1.0) << "the exponent undoes the zeros";
    EXPECT_EQ(numberIn("1" + std::string(400, '0') + "e-400"), 1.0);
    EXPECT_EQ(numberIn("0e2147483647"), 0.0);
}

TEST(Numbers, refusesWhatDoesNotFit) {
    for (const char* text : {"1.8e308", "-1e309", "1e999999999", "1e-400", "-1e-2147483648", "1e2147483648", "1e99999999999999999999",
                             "1e-99999999999999999999"})
        EXPECT_TRUE(std::isnan(numberIn(text))) << text;
    EXPECT_TRUE(std::isnan(numberIn<float>("3.5e38")));
    EXPECT_TRUE(std::isnan(numberIn<float>("1e-46")));
    EXPECT_TRUE(std::isnan(numberIn(std::string(2001, '1'))));
    std::string one(2000, '0');
    one.back() = '1';
    EXPECT_EQ(numberIn(one), 1.0);
    EXPECT_TRUE(std::isnan(numberIn(std::string(2000, '9')))) << "the longest text, and too large";
}

TEST(Numbers, refusesWhatIsNoNumber) {
    for (const char* text : {"",      "-",     "+",    ".",   "-.",       "e5",  ".e5", "1e",     "1e+",   "1e-",   "1e+-5",   "1e-+5",
                             "1e5.5", "1.2.3", "1,5",  "1 ",  " 1",       "1\n", "1x",  "--1",    "+1",    "0x10",  "0x1p3",   "1p3",
                             "1f",    "inf",   "-inf", "INF", "infinity", "nan", "NAN", "nan(1)", "1_000", "1'000", "\xd9\xa1"})
        EXPECT_TRUE(std::isnan(numberIn(text))) << "'" << text << "'";
    EXPECT_TRUE(std::isnan(numberIn(std::string_view("1\0", 2))));
}

TEST(Numbers, aRefusedTextLeavesTheValueAlone) {
    double value = 7;
    EXPECT_FALSE(readNumber("1e999", value));
    EXPECT_FALSE(readNumber("12x", value));
    EXPECT_EQ(value, 7);
    uint32_t whole = 7;
    EXPECT_FALSE(readNumber("12x", whole));
    EXPECT_EQ(whole, 7u);
}

TEST(Numbers, readsAViewThatGoesOnBehindIt) {
    EXPECT_EQ(numberIn(std::string_view("1.2534").substr(0, 4)), 1.25);
    EXPECT_EQ(numberIn(std::string_view("12e34").substr(0, 4)), 12e3);
}

TEST(Numbers, wholeNumbersFillTheirText) {
    uint32_t value = 0;
    EXPECT_TRUE(readNumber("4294967295", value));
    EXPECT_EQ(value, 4294967295u);
    for (const char* text : {"", "4294967296", "-1", "1.0", "1e1", " 1", "1 ", "+1"}) EXPECT_FALSE(readNumber(text, value)) << text;
    int32_t negative = 0;
    EXPECT_TRUE(readNumber("-2147483648", negative));
    EXPECT_EQ(negative, std::numeric_limits<int32_t>::min());
}

TEST(Numbers, theDecimalCommaOfALocaleChangesNothing) {
    const DecimalComma comma;
    if (!comma.active()) GTEST_SKIP() << "this C library does not load glibc's locale files";
    EXPECT_EQ(numberIn("1.5"), 1.5);
    EXPECT_EQ(numberIn("-12.25e-1"), -1.225);
    EXPECT_EQ(numberIn<float>("0.75"), 0.75f);
    EXPECT_TRUE(std::isnan(numberIn("1,5")));
    EXPECT_EQ(formatText("{}", 1.5), "1.5");
}

TEST(Numbers, textsTakeValuesOfEveryKind) {
    EXPECT_EQ(formatText("{} of {} in '{}'{}", 3, size_t(7), std::string("a"), '!'), "3 of 7 in 'a'!");
    EXPECT_EQ(formatText("{} {} {}", std::numeric_limits<int64_t>::min(), std::numeric_limits<uint64_t>::max(), true),
              "-9223372036854775808 18446744073709551615 1");
    EXPECT_EQ(formatText("{} {}", uint8_t(65), int8_t(-3)), "65 -3") << "bytes are numbers";
    EXPECT_EQ(formatText("{} {} {} {}", 0.1f, 1234567.0, -1e-7, std::numeric_limits<double>::infinity()), "0.1 1.23457e+06 -1e-07 inf");
    EXPECT_EQ(formatText("{} and {}", 1), "1 and {}") << "a value that is missing";
    EXPECT_EQ(formatText("none", 1), "none") << "a value too many";
    EXPECT_EQ(formatText("{}{}", "{}", 2), "{}2") << "a value is not read for holes";
    EXPECT_EQ(formatText("", 1), "");
}

}  // namespace
