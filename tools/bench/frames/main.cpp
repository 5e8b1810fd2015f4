// SPDX-License-Identifier: Apache-2.0
// bench_frames: compares the renderers of `doppel bench` with the frozen plain frame, before any optimisation.
#include <cstdio>

#include "apps/bench/bench.h"
#include "apps/shared/checks.h"
#include "reconstruction/run/progress.h"
#include "tools/bench/frames/frame_contestants.h"
#include "tools/bench/frames/model_table.h"
#include "tools/bench/frames/worth.h"

namespace dpl {
namespace {

class FrameExtras final : public BenchExtras {
public:
    FrameExtras(const BenchOptions& options, const ModelMachine& machine) : machine_(machine) {
        worth_.compared = !options.withoutReference;
    }
    void add(const BenchCase& test, const std::vector<Contestant>& list, const BenchSubject& subject,
             const ReferenceFile& referee) override {
        worth_.add(test, list);
        model_ += modelOf(test, list, subject, referee, machine_);
    }
    std::string text() const override {
        std::string out =
            "\nPlain float: the frozen frame of tools/bench/baseline, before any optimisation, always one sample a pixel. It draws only\n"
            "splats that face the view and reach 1/255.\n"
            "Worth: the ratio of each round, median and quartiles.\n" +
            worth_.text();
        if (model_.empty()) return out;
        return out +
               formatText(
                   "\nA MODEL, NOT A MEASUREMENT (docs/model.md): bytes that each pass moves and operations that it does, from counted "
                   "survivors, at {} GB/s and {} GFLOP/s, the longer of the two; no caches, no blending, no pixels of quads.\n\n"
                   "| case, today's fill | pass | plain float: MB read + written | 10⁶ operations | expected ms | today: MB read + written "
                   "| 10⁶ operations | expected ms |\n|---|---|---|---|---|---|---|---|\n{}",
                   machine_.gbps, machine_.gflops, model_);
    }
    std::string json() const override { return worth_.json; }

private:
    ModelMachine machine_;
    BenchWorth worth_;
    std::string model_;
};

}  // namespace
}  // namespace dpl

int main(int argc, char** argv) {
    using namespace dpl;
    CLI::App app{"What the optimisations of the GPU frame are worth.", "bench_frames"};
    BenchOptions options;
    options.renderers = frameRenderers();
    addBenchOptions(app, options, frameRenderers());
    std::pair<double, double> machine{ModelMachine{}.gbps, ModelMachine{}.gflops};
    app.add_option("--model", machine, "The machine of the model table (docs/model.md): 10^9 bytes and 10^9 operations a second")
        ->check(inRange(0.1, 1e6))
        ->capture_default_str();
    app.add_option("--shrink", options.shrink,
                   "Divide the sides of all pictures, for a quick look on a slow driver; names keep the full size")
        ->check(inRange(1, 64));
    app.footer("Example:\n  bench_frames demo/avatar/avatar.glb --repeats 9 --json frames.jsonl");
    CLI11_PARSE(app, argc, argv);
    installSignalHandlers();
    FrameExtras extras(options, {machine.first, machine.second});
    if (const Status done = runBench(options, frameContestant, extras); !done) {
        std::fprintf(stderr, "bench_frames: %s\n", done.error().message.c_str());
        return done.error().code == Code::Cancelled ? 130 : 1;
    }
    return 0;
}
