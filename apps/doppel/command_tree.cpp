// SPDX-License-Identifier: Apache-2.0
#include "apps/doppel/command_tree.h"

#include <algorithm>

namespace dpl {
namespace {

/** The values in "TEXT:{draft,standard,high}", as the parser names the type of an option that takes one of them. */
std::vector<std::string> choicesIn(const std::string& typeName) {
    std::vector<std::string> choices;
    const size_t open = typeName.find('{'), close = typeName.find('}', open);
    if (open == std::string::npos || close == std::string::npos) return choices;
    for (size_t at = open + 1; at < close;) {
        const size_t end = std::min(typeName.find(',', at), close);
        choices.push_back(typeName.substr(at, end - at));
        at = end + 1;
    }
    return choices;
}

CommandOption describe(const CLI::Option& option) {
    CommandOption o;
    for (const std::string& name : option.get_snames()) o.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) o.names.push_back("--" + name);
    o.positional = o.names.empty();
    if (o.positional) o.names.push_back(option.get_name(/*positional=*/true));
    const std::string type = option.get_type_name();
    o.help = option.get_description();
    o.fallback = option.get_default_str();
    o.choices = choicesIn(type);
    o.takesValue = option.get_items_expected_max() > 0;
    o.required = option.get_required();
    o.number = type.rfind("INT", 0) == 0 || type.rfind("UINT", 0) == 0 || type.rfind("FLOAT", 0) == 0;
    return o;
}

CommandEntry treeBelow(const CLI::App& app, std::vector<std::string> path) {
    CommandEntry entry;
    entry.path = std::move(path);
    entry.path.push_back(app.get_name());
    entry.help = app.get_description();
    entry.footer = app.get_footer();
    for (const CLI::Option* option : app.get_options([](const CLI::Option* o) { return !o->get_group().empty(); }))
        entry.options.push_back(describe(*option));
    for (const CLI::App* command : app.get_subcommands([](const CLI::App* a) { return !a->get_group().empty(); }))
        entry.commands.push_back(treeBelow(*command, entry.path));
    return entry;
}

}  // namespace

bool CommandEntry::standsAlone() const {
    return commands.empty() || std::any_of(options.begin(), options.end(), [](const CommandOption& o) { return o.positional; });
}

CommandEntry commandTree(const CLI::App& app) {
    return treeBelow(app, {});
}

std::vector<const CommandEntry*> allCommands(const CommandEntry& entry) {
    std::vector<const CommandEntry*> all = {&entry};
    for (const CommandEntry& command : entry.commands) {
        const auto below = allCommands(command);
        all.insert(all.end(), below.begin(), below.end());
    }
    return all;
}

std::string joined(const std::vector<std::string>& words, const std::string& between) {
    std::string text;
    for (const std::string& word : words) text += (text.empty() ? "" : between) + word;
    return text;
}

}  // namespace dpl
