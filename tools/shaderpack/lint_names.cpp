// SPDX-License-Identifier: Apache-2.0
#include "tools/shaderpack/lint_names.h"

#include <algorithm>
#include <map>

namespace dpl {
namespace {

/** Functions of the Metal Shading Language 2.3 that our shaders may call, checked against its specification. A shader that needs another
 *  one adds it here. */
const std::set<std::string> kFunctions = {
    // math and common; those of the namespace `fast` assume finite numbers
    "abs", "acos", "asin", "atan", "atan2", "ceil", "clamp", "cos", "exp", "exp2", "floor", "fma", "fmod", "fract", "ldexp", "log", "log2",
    "max", "min", "mix", "pow", "powr", "precise::atan2", "precise::tanh", "rint", "round", "rsqrt", "saturate", "sign", "sin",
    "smoothstep", "sqrt", "step", "tan", "trunc", "fast::clamp", "fast::max", "fast::min", "fast::normalize", "fast::length",
    "fast::distance",
    // geometric and relational
    "cross", "distance", "dot", "length", "normalize", "reflect", "determinant", "transpose", "all", "any", "isfinite", "isinf", "isnan",
    "select",
    // integers and packing
    "clz", "ctz", "popcount", "reverse_bits", "extract_bits", "insert_bits", "mulhi", "pack_float_to_snorm2x16", "pack_float_to_unorm4x8",
    "pack_float_to_unorm2x16", "unpack_snorm2x16_to_float", "unpack_unorm4x8_to_float", "unpack_unorm2x16_to_float",
    // threads and memory
    "threadgroup_barrier", "atomic_fetch_add_explicit", "atomic_fetch_and_explicit", "atomic_fetch_max_explicit",
    "atomic_fetch_min_explicit", "atomic_fetch_or_explicit", "atomic_fetch_sub_explicit", "atomic_exchange_explicit",
    "atomic_load_explicit", "atomic_store_explicit", "simd_shuffle", "simd_shuffle_xor", "simd_sum", "simd_prefix_exclusive_sum",
    // fragments
    "discard_fragment", "get_sample_position"};
const std::set<std::string> kMembers = {"read", "get_width", "get_height", "get_array_size", "get_num_samples"};  // of textures
const std::set<std::string> kKeywords = {"if",     "for",  "while", "switch",        "return",
                                         "sizeof", "else", "do",    "static_assert", "__attribute__"};

bool isType(const std::string& name) {
    static const std::set<std::string> all = [] {
        std::set<std::string> types = {"packed_float3", "packed_float2", "packed_float4", "size_t", "atomic_uint", "atomic_int"};
        for (const char* scalar : {"bool", "char", "uchar", "short", "ushort", "int", "uint", "half", "float", "long", "ulong"})
            for (const char* width : {"", "2", "3", "4"}) types.insert(std::string(scalar) + width);
        for (const char* matrix : {"2x2", "2x3", "2x4", "3x2", "3x3", "3x4", "4x2", "4x3", "4x4"})
            types.insert(std::string("float") + matrix);
        return types;
    }();
    return all.count(name) > 0;
}

/** Address spaces of the parameters and local variables of a function. */
std::map<std::string, std::string> spacesOf(const MslText& text, const MslFunction& f) {
    std::map<std::string, std::string> spaces;
    for (const MslParameter& p : f.parameters) spaces[p.name] = p.refers ? p.space : "thread";
    const std::vector<std::string>& t = text.tokens;
    for (size_t i = f.bodyBegin; i + 2 < f.bodyEnd; ++i) {
        const std::string& next = t[i + 2];
        const bool declares =
            isMslName(t[i]) && !kKeywords.count(t[i]) && isMslName(t[i + 1]) && (next == "=" || next == ";" || next == "[");
        const bool ofTemplate = t[i] == ">" && isMslName(t[i + 1]) && (next == ";" || next == "=");
        if (!declares && !ofTemplate) continue;
        size_t first = i;
        while (first > f.bodyBegin && t[first - 1] != ";" && t[first - 1] != "{" && t[first - 1] != "}" && t[first - 1] != "(") --first;
        spaces[t[i + 1]] = t[first] == "threadgroup" ? "threadgroup" : "thread";
    }
    return spaces;
}

/** The variable that an argument names, if it is one or a part of one; else nothing: it is a temporary. */
std::string rootOf(const std::vector<std::string>& argument) {
    if (argument.empty() || !isMslName(argument[0])) return {};
    for (size_t i = 1; i < argument.size();) {
        if (argument[i] == ".")
            i += 2;
        else if (argument[i] == "[")
            i = mslClosing(argument, i);
        else
            return {};
    }
    return argument[0];
}

/** What is wrong with the arguments of a call, or nothing. */
std::string mismatch(const MslFunction& callee, const std::vector<std::vector<std::string>>& arguments,
                     const std::map<std::string, std::string>& spaces) {
    if (callee.parameters.size() != arguments.size()) return "it takes " + std::to_string(callee.parameters.size()) + " arguments";
    for (size_t i = 0; i < arguments.size(); ++i) {
        const MslParameter& p = callee.parameters[i];
        if (!p.refers) continue;
        const auto space = spaces.find(rootOf(arguments[i]));
        const std::string from = space == spaces.end() ? "thread" : space->second;  // a temporary, or a global of another kind
        if (from != p.space) return "'" + p.name + "' is in " + p.space + " memory, and is given one in " + from + " memory";
    }
    return {};
}

}  // namespace

Status lintNames(std::string_view name, const MslText& text) {
    std::set<std::string> defined = text.types;
    for (const MslFunction& f : text.functions) defined.insert(f.name);
    for (const MslFunction& f : text.functions)
        for (size_t i = f.bodyBegin; i + 1 < f.bodyEnd; ++i) {
            const std::string& t = text.tokens[i];
            if (text.tokens[i + 1] != "(" || !isMslName(t)) continue;
            const bool member = i > 0 && text.tokens[i - 1] == ".";
            if (member ? kMembers.count(t) > 0 : kFunctions.count(t) || kKeywords.count(t) || isType(t) || defined.count(t)) continue;
            return fail(Code::InvalidArgument, "{}: '{}' is no function of Metal's that the lint knows (tools/shaderpack/lint_names.cpp)",
                        name, t);
        }
    return {};
}

Status lintAddressSpaces(std::string_view name, const MslText& text) {
    for (const std::string& global : text.globals)
        return fail(Code::InvalidArgument, "{}: '{}' lies outside functions and is not constant", name, global);
    for (const MslFunction& f : text.functions)
        for (const MslParameter& p : f.parameters)
            if (p.refers && p.space.empty())
                return fail(Code::InvalidArgument, "{}: '{}' of {}() has no address space", name, p.name, f.name);
    for (const MslFunction& f : text.functions) {
        const auto spaces = spacesOf(text, f);
        for (size_t i = f.bodyBegin; i + 1 < f.bodyEnd; ++i) {
            if (text.tokens[i + 1] != "(") continue;
            std::string wrong;
            for (const MslFunction& callee : text.functions) {
                if (callee.name != text.tokens[i]) continue;
                wrong = mismatch(callee, mslList(text.tokens, i + 2, mslClosing(text.tokens, i + 1) - 1), spaces);
                if (wrong.empty()) break;
            }
            if (!wrong.empty()) return fail(Code::InvalidArgument, "{}: {}() calls {}(): {}", name, f.name, text.tokens[i], wrong);
        }
    }
    return {};
}

}  // namespace dpl
