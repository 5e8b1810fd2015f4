// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <string_view>
#include <system_error>

#include "apps/doppel/commands.h"
#include "apps/doppel/interruption.h"
#include "apps/doppel/talk.h"
#include "apps/shared/checks.h"
#include "reconstruction/run/run_news.h"
#include "reconstruction/subject/body/solver_log.h"

namespace dpl {

int reportError(const Error& error) {
    std::fprintf(stderr, "doppel: %s\n", error.message.c_str());
    return error.code == Code::Cancelled ? kExitCancelled : error.code == Code::InvalidArgument ? kExitUsage : kExitFailed;
}

namespace {

/** How errors are told when the arguments cannot be parsed, a command throws, or Ctrl-C ends it: a program that asked for JSON parses
 * standard output. */
Talk talkOf(int argc, char** argv) {
    Talk talk;
    talk.json = std::any_of(argv + 1, argv + argc, [](std::string_view word) { return word == "--json"; });
    return talk;
}

/** The command as typed so far: "doppel body import". */
std::string commandLine(const CLI::App& app) {
    std::string text = app.get_name();
    for (const CLI::App* command : app.get_subcommands()) text += " " + commandLine(*command);
    return text;
}

/** Flushes the tables or JSON on standard output. Reports an error if they could not be written (full disk, closed pipe). */
int flushOutput(int exitCode) {
    if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return exitCode;
    return reportError(fail(Code::Io, "cannot write to standard output: {}", std::strerror(errno)));
}

}  // namespace
}  // namespace dpl

int main(int argc, char** argv) {
    using namespace dpl;
    CLI::App app{"Doppel: from a phone scan to a drivable, photoreal avatar.", "doppel"};
    app.set_version_flag("--version", "doppel " DOPPEL_VERSION);
    app.require_subcommand(1);
    app.footer(
        "Examples:\n"
        "  doppel sample-avatar -o ada.glb             an avatar to try, in seconds\n"
        "  doppel setup                                get networks and COLMAP, once\n"
        "  doppel sample -o scan                       make the procedural subject's scan\n"
        "  doppel check scan -o ada                    say what to film again\n"
        "  doppel reconstruct scan -o ada              make ada/avatar.glb and ada/report.html\n"
        "  doppel render ada/avatar.glb -o ada.mp4 --turntable\n"
        "  doppel share ada -o ada.html                one page with the person alive, to send\n"
        "  doppel dress ada/avatar.glb --top ben/avatar.glb -o new.glb\n"
        "  doppel render ada/avatar.glb -o walk.mp4 --clip walk.bvh --stereo\n"
        "Exit codes: 0 done, 1 failed (the sentence says why), 2 wrong arguments, 130 stopped by Ctrl-C (a rerun continues).\n"
        "Each command has its own --help.");
    CommandRun run;
    addSetupCommand(app, run);
    addSampleCommand(app, run);
    addSampleAvatarCommand(app, run);
    addCamerasCommand(app, run);
    addCheckCommand(app, run);
    addImportCommand(app, run);
    addReconstructCommand(app, run);
    addPresetsCommand(app, run);
    addEvaluateCommand(app, run);
    addRenderCommand(app, run);
    addInspectCommand(app, run);
    addExportCommand(app, run);
    addPackCommand(app, run);
    addDressCommand(app, run);
    addShareCommand(app, run);
    addBodyCommand(app, run);
    addBenchCommand(app, run);
    addCompletionCommand(app, run);
    addManualCommand(app, run);
    if (argc < 2) {
        std::fputs(app.help().c_str(), stderr);
        return kExitUsage;
    }
    const Talk talk = talkOf(argc, argv);
    if (const std::string unknown = unknownCommand(app, argc, argv); !unknown.empty())
        return talk.fail(fail(Code::InvalidArgument, "{}. See doppel --help", unknown));
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == 0) return flushOutput(app.exit(error));  // --help and --version
        return talk.fail(fail(Code::InvalidArgument, "{}. See {} --help", error.what(), commandLine(app)));
    }
    installSignalHandlers();
    std::signal(SIGXFSZ, SIG_IGN);  // past `ulimit -f` a write fails and is reported, as on a full disk
    silenceSolverLog();
    try {
        return flushOutput(endedSoonAfterInterrupt(run, [&talk] {
            RunNews::sayStopped();
            return talk.fail(Error{Code::Cancelled, "stopped"});
        }));
    } catch (const std::bad_alloc&) {
        return talk.fail(fail(Code::OutOfMemory, "out of memory; close other programs or use a smaller preset"));
    } catch (const std::system_error& error) {
        if (error.code() != std::errc::resource_unavailable_try_again) return talk.fail(fail(Code::Internal, "{}", error.what()));
        return talk.fail(
            fail(Code::OutOfMemory,
                 "no thread can be started: this machine, or a limit (ulimit -v, ulimit -u), grants too little memory or too few "
                 "threads; close other programs, or raise the limit"));
    } catch (const std::exception& error) {  // a reconstruction stage may throw
        return talk.fail(fail(Code::Internal, "{}", error.what()));
    }
}
