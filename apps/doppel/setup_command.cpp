// SPDX-License-Identifier: Apache-2.0
// `doppel setup`: what videos need besides `doppel`. tools/models fetches the networks; COLMAP and ffmpeg are the system's packages.
#include <unistd.h>

#include <cstdio>
#include <iostream>

#include "apps/doppel/beside_tool.h"
#include "apps/doppel/commands.h"
#include "reconstruction/base/models_folder.h"
#include "reconstruction/base/program.h"
#include "reconstruction/input/cameras/colmap_run.h"
#include "reconstruction/run/progress.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

struct SetupOptions {
    bool yes = false, check = false;
    fs::path out, package;
};

/** The script that fetches networks: beside an installed program, or of the source tree that the program was built in. */
Result<fs::path> networksScript() {
    std::error_code ignored;
    const auto candidates = besideTool(fs::path(DOPPEL_SETUP_FOLDER) / "models", "tools/models");
    for (const fs::path& candidate : candidates)
        if (fs::is_regular_file(candidate, ignored)) return candidate;
    return fail(Code::NotFound, "{} is missing, which fetches the networks; install Doppel again", candidates[0].string());
}

/** Runs a program whose words go to the terminal. Its last sentence is the error. */
Status runAloud(std::vector<std::string> arguments) {
    ProgramRun run;
    run.arguments = std::move(arguments);
    run.environment = {"DEBIAN_FRONTEND=noninteractive", "PYTHONUNBUFFERED=1"};
    run.cancel = &Progress::cancelFlag();
    std::string last;
    run.line = [&last](std::string_view line) {
        std::printf("%.*s\n", int(line.size()), line.data());
        std::fflush(stdout);
        if (!line.empty()) last = line;
    };
    const Status ended = runProgram(run);
    if (ended || ended.error().code == Code::Cancelled || last.empty()) return ended;
    constexpr std::string_view kName = "tools/models: ";
    return fail(ended.error().code, "{}", last.starts_with(kName) ? last.substr(kName.size()) : last);
}

Result<std::string> answerOf(std::vector<std::string> arguments) {
    ProgramRun run;
    run.arguments = std::move(arguments);
    std::string text;
    run.line = [&text](std::string_view line) { text += std::string(line); };
    DPL_RETURN_IF_ERROR(runProgram(run));
    return text;
}

/** Whether the person at the terminal says yes. */
Result<bool> agreed(bool yes) {
    if (yes) return true;
    if (::isatty(STDIN_FILENO) == 0)
        return fail(Code::InvalidArgument, "nobody is at the terminal to agree to these licences; say so with --yes");
    std::printf("Fetch and install this? [y/N] ");
    std::fflush(stdout);
    std::string answer;
    std::getline(std::cin, answer);
    return answer == "y" || answer == "Y" || answer == "yes";
}

struct SystemPackage {
    const char *program, *package, *what;
};
constexpr SystemPackage kSystemPackages[] = {
    {"ffmpeg", "ffmpeg", "ffmpeg, which reads videos (LGPL or GPL)"},
    {kColmapProgram, "colmap", "COLMAP, which finds where the phone was (BSD)"},
};

/** Installs packages as root; else says which command does. */
Status installPackages(const std::vector<std::string>& packages) {
    if (packages.empty()) return {};
    std::string names;
    for (const std::string& package : packages) names += " " + package;
    if (!findProgram("apt-get"))
        return fail(Code::NotFound, "install{} with this system's package manager: apt-get is not here. Everything else is done", names);
    if (::geteuid() != 0) return fail(Code::NotFound, "run `sudo apt-get install{}`, which needs root. Everything else is done", names);
    std::vector<std::string> arguments = {"apt-get", "install", "-y", "--no-remove", "--no-install-recommends"};
    arguments.insert(arguments.end(), packages.begin(), packages.end());
    if (Status done = runAloud(arguments); !done)
        return fail(done.error().code, "apt-get cannot install{}: {}. Run `apt-get update`, then the same command again", names,
                    done.error().message);
    return {};
}

Status setUp(const SetupOptions& options) {
    const fs::path folder = options.out.empty() ? userModelsFolder() : options.out;
    if (folder.empty())
        return fail(Code::InvalidArgument,
                    "neither HOME nor XDG_DATA_HOME says where networks belong; name a folder with --out, and later "
                    "that folder with --models");
    DPL_TRY(const fs::path script, networksScript());
    if (!findProgram("python3")) return fail(Code::NotFound, "python3 is missing, which fetches the networks; apt-get install python3");
    const auto models = [&](std::vector<std::string> more) {
        std::vector<std::string> arguments = {"python3", script.string(), "--out", folder.string()};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return arguments;
    };
    const bool networks = !answerOf(models({"--check"}));  // missing or not as expected
    std::vector<std::string> packages;
    if (networks) {
        DPL_TRY(const std::string what, answerOf(models({"--describe"})));
        std::printf("missing: networks, which find the person: %s in %s\n", what.c_str(), folder.c_str());
    }
    for (const SystemPackage& one : kSystemPackages)
        if (!findProgram(one.program)) {
            packages.push_back(one.package);
            std::printf("missing: %s, by this system's packages\n", one.what);
        }
    if (!networks && packages.empty()) {
        std::printf("Everything is there: networks in %s, ffmpeg and COLMAP. Next: doppel check --static walk.mp4 -o OUT\n",
                    folder.c_str());
        return {};
    }
    if (options.check) return fail(Code::NotFound, "the lines above say what is missing; doppel setup gets it");
    DPL_TRY(const bool go, agreed(options.yes));
    if (!go) return fail(Code::Cancelled, "nothing was fetched");
    if (networks)
        DPL_RETURN_IF_ERROR(runAloud(models(options.package.empty() ? std::vector<std::string>{}
                                                                    : std::vector<std::string>{"--package", options.package.string()})));
    DPL_RETURN_IF_ERROR(installPackages(packages));
    std::printf("Done. Next: doppel check --static walk.mp4 -o OUT\n");
    return {};
}

}  // namespace

void addSetupCommand(CLI::App& app, CommandRun& run) {
    auto options = std::make_shared<SetupOptions>();
    CLI::App* command = app.add_subcommand("setup", "Get what videos need besides doppel: networks, COLMAP and ffmpeg");
    command->add_flag("--yes", options->yes, "Agree to the licences that are named, and ask nothing");
    command->add_flag("--check", options->check, "Say what is missing; fetch nothing");
    command->add_option("--out", options->out, "Folder for the networks; default: where doppel looks by itself");
    command->add_option("--package", options->package, "Archive of the networks that was fetched elsewhere")->check(CLI::ExistingFile);
    command->footer(
        "Examples:\n"
        "  doppel setup                         says what is missing, from where it comes and under which licences, and asks\n"
        "  doppel setup --yes                   the same without a question, for scripts\n"
        "  doppel setup --check                 exit code 0: everything is there\n"
        "Archives are pinned by their SHA-256. A fetch that is cut goes on when the same command runs again; what is installed stays "
        "until\n"
        "the new files are whole. COLMAP and ffmpeg are packages of the system, which only root can install.");
    command->callback([options, &run] {
        run = [options] {
            const Status done = setUp(*options);
            return done ? int(kExitOk) : reportError(done.error());
        };
    });
}

}  // namespace dpl
