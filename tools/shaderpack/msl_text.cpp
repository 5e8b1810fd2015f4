// SPDX-License-Identifier: Apache-2.0
#include "tools/shaderpack/msl_text.h"

#include <algorithm>
#include <cctype>

namespace dpl {
namespace {

bool opens(const std::string& t) {
    return t == "(" || t == "[" || t == "{";
}
bool closes(const std::string& t) {
    return t == ")" || t == "]" || t == "}";
}

MslParameter parameterOf(const std::vector<std::string>& tokens) {
    MslParameter p;
    for (const std::string& t : tokens) {
        if (t == "device" || t == "constant" || t == "thread" || t == "threadgroup") p.space = t;
        if (t == "&" || t == "*" || t == "[") p.refers = true;
        if (isMslName(t) && t != "const") {
            if (p.refers && tokens.back() == "]" && !p.name.empty() && p.name != "uint" && p.name != "float") continue;  // extents
            p.name = t;
        }
    }
    if (const auto ref = std::find(tokens.begin(), tokens.end(), "&"); ref != tokens.end() && ref + 1 != tokens.end()) p.name = *(ref + 1);
    return p;
}

}  // namespace

bool isMslName(const std::string& token) {
    return !token.empty() && (std::isalpha(static_cast<unsigned char>(token[0])) || token[0] == '_');
}

std::vector<std::string> mslTokens(std::string_view text) {
    std::vector<std::string> tokens;
    const auto name = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; };
    bool lineBegins = true;
    for (size_t i = 0; i < text.size();) {
        const char c = text[i];
        if (c == '\n') lineBegins = true;
        if (std::isspace(static_cast<unsigned char>(c))) {
            ++i;
        } else if ((c == '#' && lineBegins) || text.substr(i, 2) == "//") {
            i = std::min(text.find('\n', i), text.size());
        } else if (text.substr(i, 2) == "/*") {
            i = std::min(text.find("*/", i), text.size() - 2) + 2;
        } else if (text.substr(i, 2) == "[[") {
            i = std::min(text.find("]]", i), text.size() - 2) + 2;
        } else if (name(c)) {
            size_t end = i;
            while (end < text.size() && (name(text[end]) || (text[end] == '.' && std::isdigit(static_cast<unsigned char>(c))) ||
                                         (text.substr(end, 2) == "::" && ++end)))
                ++end;
            tokens.emplace_back(text.substr(i, end - i));
            i = end;
        } else {
            tokens.emplace_back(1, c);
            ++i;
        }
        if (c != '\n' && !std::isspace(static_cast<unsigned char>(c))) lineBegins = false;
    }
    return tokens;
}

size_t mslClosing(const std::vector<std::string>& tokens, size_t open) {
    int depth = 0;
    for (size_t i = open; i < tokens.size(); ++i) {
        depth += opens(tokens[i]) - closes(tokens[i]);
        if (depth == 0) return i + 1;
    }
    return tokens.size();
}

std::vector<std::vector<std::string>> mslList(const std::vector<std::string>& tokens, size_t begin, size_t end) {
    std::vector<std::vector<std::string>> list;
    int depth = 0;
    bool ofTemplate = false;  // in the <> of SPIRV-Cross's array type; any other '<' compares
    for (size_t i = begin; i < end; ++i) {
        if (list.empty()) list.emplace_back();
        if (tokens[i] == "spvUnsafeArray") ofTemplate = true, ++depth;
        if (ofTemplate && tokens[i] == ">") ofTemplate = false, --depth;
        depth += opens(tokens[i]) - closes(tokens[i]);
        if (depth == 0 && tokens[i] == ",")
            list.emplace_back();
        else
            list.back().push_back(tokens[i]);
    }
    return list;
}

MslText parseMsl(std::string_view text) {
    MslText parsed;
    parsed.tokens = mslTokens(text);
    const std::vector<std::string>& t = parsed.tokens;
    for (size_t i = 0; i < t.size();) {
        const size_t begin = i;
        while (i < t.size() && t[i] != ";" && t[i] != "{" && t[i] != "(" && t[i] != "=") {
            if (t[i] == "struct" || t[i] == "typename" || t[i] == "class") parsed.types.insert(i + 1 < t.size() ? t[i + 1] : "");
            ++i;
        }
        if (i == t.size()) break;
        const bool isType = std::find(t.begin() + ptrdiff_t(begin), t.begin() + ptrdiff_t(i), "struct") != t.begin() + ptrdiff_t(i);
        if (t[i] == "(" && i > begin && t[i - 1] == "__attribute__") {
            i = mslClosing(t, i);
            while (i < t.size() && t[i] != "(") ++i;  // that of the parameters
        }
        if (i < t.size() && t[i] == "(" && !isType) {
            MslFunction f;
            f.name = t[i - 1];
            const size_t close = mslClosing(t, i);
            for (const auto& parameter : mslList(t, i + 1, close - 1)) f.parameters.push_back(parameterOf(parameter));
            i = close;
            if (i < t.size() && t[i] == "{") {
                f.bodyBegin = i + 1;
                i = mslClosing(t, i);
                f.bodyEnd = i - 1;
                parsed.functions.push_back(std::move(f));
            }
            continue;
        }
        const std::string name = i > begin ? t[i - 1] : "";
        if (t[begin] != "using" && !isType && t[i] == "=" &&
            std::find(t.begin() + ptrdiff_t(begin), t.begin() + ptrdiff_t(i), "constant") == t.begin() + ptrdiff_t(i))
            parsed.globals.push_back(name);
        while (i < t.size() && t[i] != ";") i = opens(t[i]) ? mslClosing(t, i) : i + 1;
        ++i;
    }
    return parsed;
}

}  // namespace dpl
