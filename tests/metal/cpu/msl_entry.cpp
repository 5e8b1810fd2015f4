// SPDX-License-Identifier: Apache-2.0
#include "tests/metal/cpu/msl_entry.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <regex>

namespace msl {
namespace {

[[noreturn]] void cannot(std::string_view name, const std::string& what) {
    std::fprintf(stderr, "%.*s: the executor does not know '%s'\n", int(name.size()), name.data(), what.c_str());
    std::abort();
}

const std::map<std::string, Given, std::less<>> kGiven = {
    {"stage_in", Given::StageIn},
    {"thread_index_in_threadgroup", Given::LaneInGroup},
    {"thread_position_in_threadgroup", Given::PlaceInGroup},
    {"thread_position_in_grid", Given::PlaceInGrid},
    {"threadgroup_position_in_grid", Given::Group},
    {"vertex_id", Given::VertexId},
    {"instance_id", Given::InstanceId},
    {"base_instance", Given::BaseInstance},
    {"render_target_array_index", Given::Layer},
    {"sample_id", Given::Sample},
    {"position", Given::Position},
};
const std::map<std::string, uint32_t, std::less<>> kFloats = {{"float", 1},  {"uint", 1},   {"int", 1},
                                                              {"float2", 2}, {"float3", 3}, {"float4", 4}};

/** The members of a struct whose members all have attributes. */
std::vector<Field> fieldsOf(std::string_view name, const std::string& text, const std::string& type, size_t& bytes) {
    std::vector<Field> fields;
    const size_t begin = text.find("struct " + type + "\n{");
    if (begin == std::string::npos) return fields;
    const std::string body = text.substr(begin, text.find("};", begin) - begin);
    const std::regex member(R"((\w+) \w+ \[\[(\w+(?:\(\w+\))?)(, flat)?\]\];)");
    uint32_t offset = 0;
    size_t lines = size_t(std::count(body.begin(), body.end(), ';'));
    for (std::sregex_iterator it(body.begin(), body.end(), member), end; it != end; ++it, --lines) {
        const auto floats = kFloats.find((*it)[1].str());
        if (floats == kFloats.end()) cannot(name, (*it)[0]);
        Field field{(*it)[2], (*it)[3].matched, floats->second, offset};
        if (field.attribute.starts_with("depth(")) field.attribute = "depth";
        fields.push_back(field);
        offset += 4 * floats->second;
    }
    if (lines != 0) cannot(name, body);  // for example centroid_perspective
    bytes = offset;
    return fields;
}

Parameter parameterOf(std::string_view name, const std::string& text) {
    std::smatch found;
    static const std::regex shape(R"(^\s*(.*?)\b(\w+) \[\[(\w+)(?:\((\d+)\))?\]\]\s*$)");
    if (!std::regex_match(text, found, shape)) cannot(name, text);
    Parameter p;
    p.name = found[2];
    const std::string attribute = found[3], type = found[1];
    if (attribute == "buffer" || attribute == "texture") {
        p.given = attribute == "buffer" ? Given::Buffer : Given::Texture;
        p.index = uint32_t(std::stoul(found[4]));
        p.writes = p.given == Given::Buffer && type.find("const") == std::string::npos;
        return p;
    }
    const auto given = kGiven.find(attribute);
    if (given == kGiven.end()) cannot(name, text);
    p.given = given->second;
    return p;
}

}  // namespace

void shaderFault(const std::string& what) {
    if (!running.faults) return;
    const std::string text = (running.entry ? running.entry->name : std::string("a shader")) + " " + what;
    if (std::find(running.faults->begin(), running.faults->end(), text) == running.faults->end()) running.faults->push_back(text);
}

void indexFault(const void* from, size_t at, size_t bytes) {
    const auto* begin = static_cast<const std::byte*>(from);
    for (const Parameter& p : running.entry->parameters) {
        if (p.given != Given::Buffer) continue;
        const Range& range = running.bindings->buffers[p.index];
        if (range.begin && begin >= range.begin && begin <= range.begin + range.bytes)
            return shaderFault("uses an element beyond the " + std::to_string(range.bytes) + " bytes of buffer(" + std::to_string(p.index) +
                               ")");
    }
    shaderFault("uses memory that is not bound");
}

const Field* Entry::output(std::string_view attribute) const {
    for (const Field& field : outputs)
        if (field.attribute == attribute) return &field;
    return nullptr;
}

bool Entry::takes(Given given) const {
    return std::any_of(parameters.begin(), parameters.end(), [&](const Parameter& p) { return p.given == given; });
}

Entry describe(std::string_view name, std::string_view msl, const std::vector<size_t>& bytes, const std::vector<TextureShape>& shapes,
               size_t outputBytes) {
    Entry entry;
    entry.name = name, entry.text = msl;
    const std::string text(msl);
    std::smatch found;
    const std::regex signature(R"(\n(kernel|vertex|fragment) [^\n]* main0\(([^\n]*)\)\n)");
    if (!std::regex_search(text, found, signature)) cannot(name, "its entry point");
    entry.stage = found[1] == "kernel" ? Stage::Compute : found[1] == "vertex" ? Stage::Vertex : Stage::Fragment;
    const std::string list = found[2];
    for (size_t begin = 0; begin < list.size();) {
        const size_t end = std::min(list.find("]], ", begin), list.size() - 2) + 2;
        entry.parameters.push_back(parameterOf(name, list.substr(begin, end - begin)));
        begin = end + 2;
    }
    if (entry.parameters.size() != bytes.size()) cannot(name, list);
    for (size_t i = 0; i < bytes.size(); ++i) {
        entry.parameters[i].bytes = entry.parameters[i].given == Given::Buffer ? bytes[i] : 0;
        entry.parameters[i].shape = shapes[i];
    }
    entry.inputs = fieldsOf(name, text, "main0_in", entry.inputBytes);
    entry.outputs = fieldsOf(name, text, "main0_out", entry.outputBytes);
    if (entry.outputBytes != outputBytes) cannot(name, "the layout of main0_out");
    const std::regex threads(R"(gl_WorkGroupSize[^=]*= uint3\((\d+)u, (\d+)u, (\d+)u\))");
    if (std::regex_search(text, found, threads))  // SPIRV-Cross omits the constant for groups of one thread
        for (int i = 0; i < 3; ++i) entry.threads[i] = uint32_t(std::stoul(found[size_t(i) + 1]));
    entry.hasBarriers = text.find("threadgroup_barrier(") != std::string::npos;
    return entry;
}

bool dispatch(const Entry& entry, const Bindings& bindings, glm::uvec3 groups, int order) {
    running.entry = &entry;
    running.discarded = false;
    const uint32_t lanes = entry.threads.x * entry.threads.y * entry.threads.z;
    const uint64_t all = uint64_t(groups.x) * groups.y * groups.z;
    bool fine = true;
    for (uint64_t i = 0; i < all; ++i) {
        const uint64_t at = order == 1 ? all - 1 - i : i;
        const glm::uvec3 group(at % groups.x, at / groups.x % groups.y, at / groups.x / groups.y);
        const auto body = [&](uint32_t lane) {
            Invocation how;
            how.bindings = &bindings;
            how.lane = lane;
            how.group = group;
            how.inGroup = {lane % entry.threads.x, lane / entry.threads.x % entry.threads.y, lane / entry.threads.x / entry.threads.y};
            how.inGrid = group * entry.threads + how.inGroup;
            entry.call(entry, how, nullptr);
        };
        if (entry.hasBarriers)
            fine &= runGroup(lanes, order, body);
        else  // any order will do: forward or backward
            for (uint32_t lane = 0; lane < lanes; ++lane) body(order == 1 ? lanes - 1 - lane : lane);
    }
    return fine;
}

bool dispatchInOrder(const Entry& entry, void* const* buffers, uint32_t groups, int order) {
    Bindings bindings;
    for (const Parameter& p : entry.parameters)
        if (p.given == Given::Buffer) bindings.buffers[p.index].begin = static_cast<std::byte*>(*buffers++);
    running = {};
    return dispatch(entry, bindings, {groups, 1, 1}, order);
}

}  // namespace msl
