// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/graph.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "sdk/core/files.h"

namespace dpl {
namespace {

/** What the stages below did, in order. */
std::vector<std::string> did;

struct Seed {
    int value = 0, unused = 0;
};
struct Doubled {
    int value = 0;
};
struct Sum {
    int value = 0;
};
struct Peeping {};

Status writeNumber(const std::filesystem::path& folder, int value) {
    return writeFileAtomically(folder / "number", std::to_string(value));
}
Result<int> readNumber(const std::filesystem::path& folder) {
    DPL_TRY(const auto bytes, readFile(folder / "number"));
    return std::stoi(std::string(bytes.begin(), bytes.end()));
}

}  // namespace

template <>
struct StageOf<Seed> {
    static constexpr StageName kName{"seed", 1};
    static Status inputs(StageInputs&) { return fail(Code::Internal, "not given"); }
};

template <>
struct StageOf<Doubled> {
    static constexpr StageName kName{"doubled", 1};
    static constexpr const char* kPriors[] = {"subject/body"};
    static Status inputs(StageInputs& in) {
        DPL_TRY(const Seed* seed, in.part<Seed>());
        in.value("value", seed->value);
        return {};
    }
    static Status make(StageInputs& in, StageContext& context) {
        did.push_back("double");
        DPL_TRY(const Seed* seed, in.of<Seed>());
        return writeNumber(context.folder, 2 * seed->value);
    }
    static Result<Doubled> read(StageInputs&, const std::filesystem::path& folder) {
        DPL_TRY(const int value, readNumber(folder));
        return Doubled{value};
    }
};

template <>
struct StageOf<Sum> {
    static constexpr StageName kName{"sum", 1};
    static Status inputs(StageInputs& in) { return in.use<Doubled>(); }
    static Result<Sum> compute(StageInputs& in) {
        did.push_back("sum");
        DPL_TRY(const Doubled* doubled, in.of<Doubled>());
        return Sum{doubled->value + 1};
    }
};

template <>
struct StageOf<Peeping> {
    static constexpr StageName kName{"peeping", 1};
    static Status inputs(StageInputs& in) { return in.use<Sum>(); }
    static Result<Peeping> compute(StageInputs& in) {
        DPL_TRY([[maybe_unused]] const Doubled* doubled, in.of<Doubled>());
        return Peeping{};
    }
};

namespace {

class Graph : public testing::Test {
protected:
    void SetUp() override {
        did.clear();
        std::filesystem::remove_all(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    /** A run of its own from this seed; what it did. */
    template <class T>
    std::vector<std::string> ask(Seed seed) {
        did.clear();
        StageChain chain(folder_, progress_);
        dpl::Run run(chain, jobs_, progress_);
        run.put(seed, "seed");
        const auto made = run.get<T>();
        EXPECT_TRUE(made) << made.error().message;
        const auto again = run.get<T>();
        EXPECT_EQ(*made, *again) << "each artefact is made once in a run";
        return did;
    }

    const std::filesystem::path folder_ = std::filesystem::temp_directory_path() / ("doppel_graph_" + std::to_string(::getpid()));
    Progress progress_{Progress::Style::Quiet};
    Jobs jobs_{1};
};

using Steps = std::vector<std::string>;

TEST_F(Graph, makesWhatIsNeededAndNothingElse) {
    EXPECT_EQ(ask<Doubled>({3, 0}), Steps{"double"});
    EXPECT_EQ(ask<Sum>({3, 0}), Steps{"sum"}) << "the files of an earlier run are up to date";
    EXPECT_EQ(ask<Sum>({4, 0}), (Steps{"double", "sum"})) << "files are made before whoever needs them";
}

TEST_F(Graph, onlyListedPartsDecide) {
    ask<Doubled>({3, 0});
    EXPECT_EQ(ask<Doubled>({3, 7}), Steps{}) << "the other field was not listed";
}

TEST_F(Graph, aStageCannotLookAtWhatItsInputsDoNotPull) {
    StageChain chain(folder_, progress_);
    dpl::Run run(chain, jobs_, progress_);
    run.put(Seed{3, 0}, "seed");
    const auto made = run.get<Peeping>();
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().code, Code::Internal);
    EXPECT_NE(made.error().message.find("do not pull"), std::string::npos);
}

TEST_F(Graph, anArtefactCanBePutInPlaceOfItsStage) {
    StageChain chain(folder_, progress_);
    dpl::Run run(chain, jobs_, progress_);
    run.put(Doubled{100}, "given");
    const auto sum = run.get<Sum>();
    ASSERT_TRUE(sum) << sum.error().message;
    EXPECT_EQ((*sum)->value, 101);
    EXPECT_EQ(did, Steps{"sum"});
    StageChain otherChain(folder_, progress_);
    dpl::Run other(otherChain, jobs_, progress_);
    other.put(Doubled{100}, "another");
    EXPECT_NE(*run.keyOf<Sum>(), *other.keyOf<Sum>());
}

TEST_F(Graph, priorsOfTheNamedRoomsAreInTheKeyAndNoOthers) {
    StageChain chain(folder_, progress_);
    dpl::Run run(chain, jobs_, progress_);
    run.put(Seed{3, 0}, "seed");
    ASSERT_TRUE(run.get<Doubled>());
    const auto bytes = readFile(folder_ / "stages/doubled/manifest.json");
    ASSERT_TRUE(bytes);
    const auto manifest = nlohmann::json::parse(bytes->begin(), bytes->end());
    EXPECT_EQ(manifest["inputs"]["priors"], priorsOf(StageOf<Doubled>::kPriors));

    std::vector<PriorValue> table(priorsTable().begin(), priorsTable().end());
    ASSERT_GT(table.size(), 50u);
    for (PriorValue& prior : table) {
        const char* const value = std::exchange(prior.value, "changed");
        EXPECT_EQ(priorsOf(StageOf<Doubled>::kPriors, table) != priorsOf(StageOf<Doubled>::kPriors),
                  std::string_view(prior.room) == "subject/body")
            << prior.name;
        prior.value = value;
    }
}

}  // namespace
}  // namespace dpl
