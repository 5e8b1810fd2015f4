// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/run_starter.h"

#include "sdk/core/files.h"

namespace dpl {

RunStarter::~RunStarter() {
    *noLonger_ = true;
}

void RunStarter::look(const std::filesystem::path& program) {
    problem_.clear();
    coach_ = {};
    program_ = program;
    job_ = std::make_unique<ProgramJob>(checkArguments(program, run));
    step_ = Step::Looking;
}

void RunStarter::begin(const std::filesystem::path& program) {
    problem_.clear();
    job_.reset();
    step_ = Step::Starting;
    starting_ = std::async(std::launch::async, [what = run, words = reconstructArguments(program, run), noLonger = noLonger_]() -> Status {
        std::error_code error;
        std::filesystem::create_directories(what.out, error);
        if (error) return fail(Code::Io, "cannot create {}: {}; choose another folder", what.out.string(), error.message());
        DPL_RETURN_IF_ERROR(writeFileAtomically(what.out / kRunRequest, runRequestToJson(what)));
        return startRun(words, what.out, *noLonger);
    });
}

void RunStarter::back() {
    if (step_ != Step::Looking && step_ != Step::Advised) return;
    job_.reset();
    step_ = Step::Choosing;
}

void RunStarter::tick() {
    if (step_ == Step::Looking) {
        const std::optional<Status> ended = job_->ended();
        if (!ended) return;
        auto words = parseCoachWords(job_->lines());
        job_.reset();
        step_ = Step::Choosing;
        if (!*ended)
            problem_ = words || words.error().code == Code::CorruptData ? ended->error().message : words.error().message;
        else if (!words)
            problem_ = words.error().message;
        else if (coach_ = std::move(*words); coach_.faults.empty())
            begin(program_);
        else
            step_ = Step::Advised;
    } else if (step_ == Step::Starting) {
        if (starting_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
        const Status started = starting_.get();
        step_ = started ? Step::Started : Step::Choosing;
        if (!started) problem_ = started.error().message;
    }
}

}  // namespace dpl
