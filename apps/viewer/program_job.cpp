// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/program_job.h"

#include "reconstruction/base/program.h"

namespace dpl {
namespace {

/** What the program says of its failure: from its last line that begins with its name to the end, without JSON. Empty: nothing. */
std::string ownSentence(const std::vector<std::string>& lines) {
    constexpr std::string_view kName = "doppel: ";
    for (size_t i = lines.size(); i-- > 0;) {
        if (!lines[i].starts_with(kName)) continue;
        std::string sentence = lines[i].substr(kName.size());
        for (size_t more = i + 1; more < lines.size(); ++more)
            if (!lines[more].starts_with('{')) sentence += "\n" + lines[more];
        return sentence;
    }
    return {};
}

}  // namespace

ProgramJob::ProgramJob(std::vector<std::string> arguments) {
    thread_ = std::thread([this, arguments = std::move(arguments)]() mutable {
        ProgramRun run;
        run.arguments = std::move(arguments);
        run.environment = {"DOPPEL_PROGRESS_SECONDS=0.5"};
        run.line = [this](std::string_view line) { hear(line); };
        run.cancel = &cancel_;
        Status end = runProgram(run);
        std::lock_guard lock(mutex_);
        if (!end && end.error().code == Code::Io)
            if (const std::string sentence = ownSentence(lines_); !sentence.empty()) end = fail(Code::Io, "{}", sentence);
        ended_ = std::move(end);
    });
}

ProgramJob::~ProgramJob() {
    cancel_ = true;
    thread_.join();
}

void ProgramJob::hear(std::string_view line) {
    std::optional<ProgressLine> progress = parseProgressLine(line);
    std::lock_guard lock(mutex_);
    if (progress) {
        progress_ = std::move(progress);
        return;
    }
    lines_.emplace_back(line);
    if (lines_.size() > kMostLines) lines_.erase(lines_.begin());
}

std::optional<ProgressLine> ProgramJob::progress() const {
    std::lock_guard lock(mutex_);
    return progress_;
}

std::vector<std::string> ProgramJob::lines() const {
    std::lock_guard lock(mutex_);
    return lines_;
}

std::optional<Status> ProgramJob::ended() const {
    std::lock_guard lock(mutex_);
    return ended_;
}

}  // namespace dpl
