// SPDX-License-Identifier: Apache-2.0
// doppel manual: prints the manual page, in the language of man(7).
#include <cstdio>

#include "apps/doppel/command_tree.h"
#include "apps/doppel/commands.h"

namespace dpl {
namespace {

/** Text in which man(7) finds no requests or escapes. */
std::string plain(const std::string& text) {
    std::string out;
    for (size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        const bool lineStart = i == 0 || text[i - 1] == '\n';
        if (lineStart && (c == '.' || c == '\'')) out += "\\&";
        out += c == '\\' ? std::string("\\e") : c == '-' ? std::string("\\-") : std::string(1, c);
    }
    return out;
}

std::string optionText(const CommandOption& o) {
    std::string head;
    for (const std::string& name : o.names) head += (head.empty() ? "\\fB" : ", \\fB") + plain(name) + "\\fR";
    if (o.takesValue && !o.positional) head += " \\fI" + (o.choices.empty() ? std::string("VALUE") : joined(o.choices, "|")) + "\\fR";
    std::string about = o.help;
    if (!o.fallback.empty()) about += " (default: " + o.fallback + ")";
    if (o.required) about += " (required)";
    return ".TP\n" + head + "\n" + plain(about) + "\n";
}

std::string synopsis(const CommandEntry& c) {
    std::string text = "\\fB" + plain(joined(c.path, " ")) + "\\fR";
    for (const CommandOption& o : c.options)
        if (o.positional) text += " \\fI" + plain(o.names[0]) + "\\fR";
    for (const CommandOption& o : c.options)
        if (!o.positional && o.required) text += " \\fB" + plain(o.names[0]) + "\\fR \\fIVALUE\\fR";
    return text + (c.standsAlone() ? " [options]" : " \\fIcommand\\fR");
}

std::string manual(const CommandEntry& root) {
    std::string text = ".TH DOPPEL 1 \"\" \"doppel " DOPPEL_VERSION "\" \"User commands\"\n.SH NAME\ndoppel \\- " +
                       plain(root.help.substr(root.help.find(": ") + 2)) +
                       "\n.SH SYNOPSIS\n.B doppel\n.I command\n[options]\n.SH OPTIONS\n";
    for (const CommandOption& o : root.options) text += optionText(o);
    text += ".SH COMMANDS\n";
    for (const CommandEntry* c : allCommands(root)) {
        if (!c->standsAlone()) continue;
        text +=
            ".SS " + plain(joined({c->path.begin() + 1, c->path.end()}, " ")) + "\n" + plain(c->help) + ".\n.PP\n" + synopsis(*c) + "\n";
        for (const CommandOption& o : c->options) text += optionText(o);
        if (!c->footer.empty()) text += ".PP\n.nf\n" + plain(c->footer) + "\n.fi\n";
    }
    return text + ".SH EXAMPLES\n.nf\n" + plain(root.footer) + "\n.fi\n";
}

}  // namespace

void addManualCommand(CLI::App& app, CommandRun& run) {
    CLI::App* command = app.add_subcommand("manual", "Print the manual page");
    command->footer("Examples:\n  doppel manual | man -l -");
    command->callback([&app, &run] {
        run = [&app] {
            std::fputs(manual(commandTree(app)).c_str(), stdout);
            return int(kExitOk);
        };
    });
}

}  // namespace dpl
