// SPDX-License-Identifier: Apache-2.0
#include "apps/doppel/talk.h"

#include <cstdio>

#include "apps/doppel/commands.h"

namespace dpl {
namespace {

const char* nameOf(Code code) {
    switch (code) {
        case Code::InvalidArgument:
            return "invalid-argument";
        case Code::NotFound:
            return "not-found";
        case Code::CorruptData:
            return "corrupt-data";
        case Code::Version:
            return "version";
        case Code::Unsupported:
            return "unsupported";
        case Code::OutOfMemory:
            return "out-of-memory";
        case Code::Io:
            return "io";
        case Code::Device:
            return "device";
        case Code::Cancelled:
            return "cancelled";
        case Code::Internal:
            return "internal";
    }
    return "internal";
}

/** File names may hold bytes that are not UTF-8; they are replaced. */
void print(const nlohmann::json& document) {
    std::printf("%s\n", document.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
}

}  // namespace

Progress::Style Talk::style() const {
    return quiet ? Progress::Style::Quiet : verbose ? Progress::Style::Verbose : Progress::Style::Usual;
}

int Talk::succeed(const std::string& text, const nlohmann::json& document) const {
    if (json)
        print(document);
    else if (!quiet && !text.empty())
        std::printf("%s\n", text.c_str());
    return kExitOk;
}

int Talk::fail(const Error& error) const {
    if (json) print({{"error", {{"code", nameOf(error.code)}, {"message", error.message}}}});
    return reportError(error);
}

std::shared_ptr<Talk> addTalkOptions(CLI::App& command) {
    auto talk = std::make_shared<Talk>();
    CLI::Option* quiet = command.add_flag("--quiet", talk->quiet, "Print errors only");
    command.add_flag("--verbose", talk->verbose, "Say more on standard error: each step and why it runs, its time and memory")
        ->excludes(quiet);
    command.add_flag("--json", talk->json, "Print the result as one line of JSON on standard output; progress stays on standard error");
    return talk;
}

}  // namespace dpl
