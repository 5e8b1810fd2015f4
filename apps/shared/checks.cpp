// SPDX-License-Identifier: Apache-2.0
#include "apps/shared/checks.h"

#include <algorithm>

#include "sdk/core/edit_distance.h"
#include "sdk/core/numbers.h"
#include "sdk/core/result.h"

namespace dpl {
namespace {

constexpr uint32_t kMaxSidePx = 8192;

std::vector<const CLI::App*> commandsOf(const CLI::App& app) {
    return app.get_subcommands([](const CLI::App*) { return true; });
}

}  // namespace

CLI::Validator inRange(double low, double high) {
    const auto check = [low, high](const std::string& text) -> std::string {
        double value = 0;
        if (readNumber(text, value) && value >= low && value <= high) return {};
        return formatText("'{}' is not a number from {} to {}", text, low, high);
    };
    return {check, formatText("from {} to {}", low, high)};
}

CLI::Validator isWholeNumber(uint64_t high) {
    const auto check = [high](const std::string& text) -> std::string {
        uint64_t value = 0;
        if (readNumber(text, value) && value <= high) return {};
        return formatText("'{}' is not a whole number from 0 to {}", text, high);
    };
    return {check, formatText("from 0 to {}", high)};
}

std::optional<PictureSize> parsePictureSize(std::string_view text) {
    PictureSize size;
    const size_t x = text.find('x');
    if (x == text.npos || !readNumber(text.substr(0, x), size.widthPx) || !readNumber(text.substr(x + 1), size.heightPx))
        return std::nullopt;
    const auto allowed = [](uint32_t sidePx) { return sidePx >= 1 && sidePx <= kMaxSidePx; };
    if (!allowed(size.widthPx) || !allowed(size.heightPx)) return std::nullopt;
    return size;
}

CLI::Validator isPictureSize() {
    const auto check = [](const std::string& text) -> std::string {
        if (parsePictureSize(text)) return {};
        return formatText("'{}' is not WIDTHxHEIGHT with sides from 1 to {}, like 720x1280", text, kMaxSidePx);
    };
    return {check, "WIDTHxHEIGHT"};
}

CLI::Validator isOutputFile(std::vector<std::string> extensions, bool orFolder) {
    std::string allowed;
    for (const std::string& extension : extensions) allowed += (allowed.empty() ? "" : ", ") + extension;
    const auto check = [=](const std::string& text) -> std::string {
        namespace fs = std::filesystem;
        const fs::path path = text;
        std::error_code ignored;
        const std::string extension = path.extension().string();
        if (orFolder && extension.empty()) return {};
        if (fs::is_directory(path, ignored)) return formatText("{} is a folder; name a file in it", text);
        if (!extensions.empty() && std::find(extensions.begin(), extensions.end(), extension) == extensions.end())
            return formatText("{}: the name must end in {}{}", text, allowed, orFolder ? ", or name a folder" : "");
        const fs::path folder = path.has_parent_path() ? path.parent_path() : ".";
        if (!fs::is_directory(folder, ignored)) return formatText("{}: there is no folder {}; make it first", text, folder.string());
        return {};
    };
    return {check, allowed.empty() ? "FILE" : allowed};
}

void refuseInputAsOutput(const std::filesystem::path& out, const std::vector<std::filesystem::path>& inputs) {
    for (const std::filesystem::path& input : inputs) {
        std::error_code missing;
        if (std::filesystem::equivalent(out, input, missing))
            throw CLI::ValidationError("--out", formatText("{} is the input {} itself; choose another -o", out.string(), input.string()));
    }
}

std::string unknownCommand(const CLI::App& app, int argc, const char* const* argv) {
    const CLI::App* at = &app;
    for (int i = 1; i < argc; ++i) {
        const std::string_view word = argv[i];
        const std::vector<const CLI::App*> commands = commandsOf(*at);
        const auto values = at->get_options([](const CLI::Option* o) { return o->get_positional(); });
        if (commands.empty() || !values.empty()) return {};
        if (word.starts_with('-')) continue;
        const auto found = std::find_if(commands.begin(), commands.end(), [&](const CLI::App* c) { return c->get_name() == word; });
        if (found != commands.end()) {
            at = *found;
            continue;
        }
        std::vector<std::string> names;
        std::string all;
        for (const CLI::App* c : commands) names.push_back(c->get_name()), all += (all.empty() ? "" : ", ") + c->get_name();
        return formatText("unknown command '{}'{}; the commands are {}", word, didYouMean(word, names), all);
    }
    return {};
}

}  // namespace dpl
