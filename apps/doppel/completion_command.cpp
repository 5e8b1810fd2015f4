// SPDX-License-Identifier: Apache-2.0
// doppel completion: prints a script that lets bash or zsh complete doppel's commands, options and values.
#include <algorithm>
#include <cstdio>

#include "apps/doppel/command_tree.h"
#include "apps/doppel/commands.h"

namespace dpl {
namespace {

/** The text in single quotes, for both shells. */
std::string quoted(const std::string& text) {
    std::string out = "'";
    for (char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return out + "'";
}

/** The first sentence, or all of a short text. */
std::string summary(const std::string& help) {
    const size_t end = help.find_first_of(".;:");
    return help.substr(0, end == std::string::npos ? help.size() : end);
}

std::string bashOf(const CommandEntry& root) {
    const auto all = allCommands(root);
    std::string paths;
    for (const CommandEntry* c : all)
        if (c->path.size() > 1) paths += (paths.empty() ? "" : "|") + quoted(joined(c->path, " "));
    std::string text =
        "# bash completion of doppel, written by `doppel completion bash`\n"
        "_doppel() {\n"
        "    local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD-1]} command=doppel word\n"
        "    COMPREPLY=()\n"
        "    for word in \"${COMP_WORDS[@]:1:COMP_CWORD-1}\"; do\n"
        "        case \"$command $word\" in\n"
        "            " +
        paths +
        ") command=\"$command $word\" ;;\n"
        "        esac\n"
        "    done\n"
        "    case $command in\n";
    for (const CommandEntry* c : all) {
        text += "    " + quoted(joined(c->path, " ")) + ")\n        case $prev in\n";
        std::vector<std::string> words;
        for (const CommandOption& o : c->options) {
            if (o.positional) continue;
            words.insert(words.end(), o.names.begin(), o.names.end());
            if (!o.takesValue) continue;
            text += "            " + joined(o.names, "|") + ") ";
            if (!o.choices.empty())
                text += "mapfile -t COMPREPLY < <(compgen -W " + quoted(joined(o.choices, " ")) + " -- \"$cur\"); ";
            else if (!o.number)
                text += "mapfile -t COMPREPLY < <(compgen -f -- \"$cur\"); ";
            text += "return ;;\n";
        }
        text += "        esac\n";
        std::vector<std::string> commands;
        for (const CommandEntry& below : c->commands) commands.push_back(below.path.back());
        const bool commandsFirst = !c->standsAlone();
        if (commandsFirst) words.insert(words.end(), commands.begin(), commands.end());
        text += std::string("        if [[ $cur == -* ") + (commandsFirst ? "|| -z $cur || $cur != */* " : "") + "]]; then\n" +
                "            mapfile -t COMPREPLY < <(compgen -W " + quoted(joined(words, " ")) + " -- \"$cur\")\n";
        const auto argument = std::find_if(c->options.begin(), c->options.end(), [](const CommandOption& o) { return o.positional; });
        if (!commandsFirst && argument != c->options.end())
            text += "        else\n            mapfile -t COMPREPLY < <(compgen " +
                    (argument->choices.empty() ? "-f" : "-W " + quoted(joined(argument->choices, " "))) +
                    (commands.empty() ? "" : " -W " + quoted(joined(commands, " "))) + " -- \"$cur\")\n";
        text += "        fi ;;\n";
    }
    return text + "    esac\n}\ncomplete -o filenames -F _doppel doppel\n";
}

/** An argument of zsh's _arguments. */
std::string zshOption(const CommandOption& o) {
    std::string about;  // inside [...] zsh reads brackets and colons
    for (char c : summary(o.help)) about += c == '[' || c == ']' ? '\'' : c;
    std::string action;
    if (!o.choices.empty())
        action = ":value:(" + joined(o.choices, " ") + ")";
    else if (o.takesValue)
        action = o.number ? ":number: " : ":file:_files";
    if (o.positional) return quoted("*:" + o.names[0] + (action.empty() ? ":_files" : action.substr(action.rfind(':'))));
    std::string text;
    for (const std::string& name : o.names) text += (text.empty() ? "" : " ") + quoted("*" + name + "[" + about + "]" + action);
    return text;
}

std::string zshName(const CommandEntry& c) {
    return "_" + joined(c.path, "_");
}

std::string zshOf(const CommandEntry& root) {
    std::string text = "#compdef doppel\n# zsh completion of doppel, written by `doppel completion zsh`\n";
    for (const CommandEntry* c : allCommands(root)) {
        text += zshName(*c) + "() {\n";
        std::string options;
        for (const CommandOption& o : c->options)
            if (!o.positional || c->standsAlone()) options += " \\\n        " + zshOption(o);
        if (c->standsAlone()) {  // what it takes, also where it has commands too
            text += "    _arguments -s" + options + "\n}\n";
            continue;
        }
        text += "    local state line\n    _arguments -C" + options + " \\\n        '1:command:->command' '*::argument:->rest'\n";
        text += "    case $state in\n    command)\n        local -a commands=(\n";
        for (const CommandEntry& below : c->commands) text += "            " + quoted(below.path.back() + ":" + summary(below.help)) + "\n";
        text += "        )\n        _describe command commands ;;\n    rest)\n        case $line[1] in\n";
        for (const CommandEntry& below : c->commands) text += "            " + below.path.back() + ") " + zshName(below) + " ;;\n";
        text += "        esac ;;\n    esac\n}\n";
    }
    return text + "if [ \"$funcstack[1]\" = _doppel ]; then _doppel; else compdef _doppel doppel; fi\n";
}

}  // namespace

void addCompletionCommand(CLI::App& app, CommandRun& run) {
    auto shell = std::make_shared<std::string>();
    CLI::App* command = app.add_subcommand("completion", "Print a script that completes commands, options and values in a shell");
    command->add_option("shell", *shell, "The shell")->required()->check(CLI::IsMember({"bash", "zsh"}));
    command->footer(
        "Examples:\n"
        "  doppel completion bash > ~/.local/share/bash-completion/completions/doppel\n"
        "  doppel completion zsh > ~/.zfunc/_doppel        with fpath+=(~/.zfunc) before compinit in .zshrc\n"
        "`cmake --install` puts both scripts and the manual page where shells and `man doppel` look.");
    command->callback([shell, &app, &run] {
        run = [shell, &app] {
            const CommandEntry root = commandTree(app);
            std::fputs((*shell == "bash" ? bashOf(root) : zshOf(root)).c_str(), stdout);
            return int(kExitOk);
        };
    });
}

}  // namespace dpl
