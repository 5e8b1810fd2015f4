// SPDX-License-Identifier: Apache-2.0
// From a dropped film to a run: the coach looks at it first (`doppel check`), then `doppel reconstruct` is started. No window is needed.
#pragma once

#include <future>
#include <memory>

#include "apps/viewer/new_run.h"
#include "apps/viewer/program_job.h"
#include "apps/viewer/run_process.h"

namespace dpl {

class RunStarter {
public:
    enum class Step : uint8_t {
        Choosing,  // run may be changed
        Looking,   // the coach looks at the film
        Advised,   // it has found faults of the film; the user decides
        Starting,  // the run has not told of itself yet
        Started,   // it has, and goes on by itself
    };
    explicit RunStarter(NewRun what) : run(std::move(what)) {}
    /** Ends the coach's look, but no run. */
    ~RunStarter();
    RunStarter(const RunStarter&) = delete;
    RunStarter& operator=(const RunStarter&) = delete;

    /** Lets the coach look, and begins if it finds no fault. program: doppel. */
    void look(const std::filesystem::path& program);
    /** Begins the run, or goes on with it. */
    void begin(const std::filesystem::path& program);
    /** Back to Choosing, from Looking and Advised. */
    void back();
    /** Call once a frame. */
    void tick();

    Step step() const { return step_; }
    /** How far the coach is. */
    std::optional<ProgressLine> progress() const { return job_ ? job_->progress() : std::nullopt; }
    const CoachWords& coach() const { return coach_; }
    /** Why the last step failed; it is Choosing again. "": it has not. */
    const std::string& problem() const { return problem_; }

    NewRun run;

private:
    Step step_ = Step::Choosing;
    std::filesystem::path program_;
    std::unique_ptr<ProgramJob> job_;
    CoachWords coach_;
    std::string problem_;
    std::shared_ptr<std::atomic<bool>> noLonger_ = std::make_shared<std::atomic<bool>>(false);
    std::future<Status> starting_;
};

}  // namespace dpl
