// SPDX-License-Identifier: Apache-2.0
#include "tools/shaderpack/msl.h"

#include <spirv_cross/spirv_cross_c.h>

#include <algorithm>
#include <memory>
#include <type_traits>

namespace dpl {
namespace {

struct ContextDeleter {
    void operator()(spvc_context context) const { spvc_context_destroy(context); }
};
using Context = std::unique_ptr<std::remove_pointer_t<spvc_context>, ContextDeleter>;

struct Module {
    Context context;
    spvc_compiler compiler = nullptr;
    spvc_resources resources = nullptr;
    Error error(std::string_view name) const {
        return fail(Code::Internal, "{}: SPIRV-Cross: {}", name, spvc_context_get_last_error_string(context.get()));
    }
};

Result<Module> openModule(const Shader& shader, spvc_backend backend) {
    Module m;
    spvc_context raw = nullptr;
    if (spvc_context_create(&raw) != SPVC_SUCCESS) return fail(Code::Internal, "SPIRV-Cross cannot be initialised");
    m.context.reset(raw);
    spvc_parsed_ir ir = nullptr;
    if (spvc_context_parse_spirv(raw, shader.spirv.data(), shader.spirv.size(), &ir) != SPVC_SUCCESS) return m.error(shader.name);
    if (spvc_context_create_compiler(raw, backend, ir, SPVC_CAPTURE_MODE_TAKE_OWNERSHIP, &m.compiler) != SPVC_SUCCESS)
        return m.error(shader.name);
    if (spvc_compiler_create_shader_resources(m.compiler, &m.resources) != SPVC_SUCCESS) return m.error(shader.name);
    return m;
}

std::span<const spvc_reflected_resource> resourcesOf(const Module& m, spvc_resource_type type) {
    const spvc_reflected_resource* list = nullptr;
    size_t count = 0;
    spvc_resources_get_resource_list_for_type(m.resources, type, &list, &count);
    return {list, count};
}

/** Adds the struct and the structs inside it. Does nothing for other types. */
void collectStructs(spvc_compiler compiler, spvc_type_id id, std::vector<ShaderStruct>& structs) {
    spvc_type type = spvc_compiler_get_type_handle(compiler, id);
    if (spvc_type_get_basetype(type) != SPVC_BASETYPE_STRUCT) return;
    const spvc_type_id base = spvc_type_get_base_type_id(type);
    ShaderStruct s;
    s.name = spvc_compiler_get_name(compiler, base);
    if (std::any_of(structs.begin(), structs.end(), [&](const ShaderStruct& known) { return known.name == s.name; })) return;
    size_t size = 0;
    spvc_compiler_get_declared_struct_size(compiler, type, &size);
    s.size = uint32_t(size);
    const unsigned count = spvc_type_get_num_member_types(type);
    for (unsigned i = 0; i < count; ++i) {
        unsigned offset = 0;
        spvc_compiler_type_struct_member_offset(compiler, type, i, &offset);
        s.members.push_back({spvc_compiler_get_member_name(compiler, base, i), offset});
        const spvc_type_id memberId = spvc_type_get_member_type(type, i);
        spvc_type member = spvc_compiler_get_type_handle(compiler, memberId);
        if (spvc_type_get_basetype(member) != SPVC_BASETYPE_STRUCT) continue;
        collectStructs(compiler, memberId, structs);
        unsigned stride = 0;
        if (spvc_type_get_num_array_dimensions(member) > 0 &&
            spvc_compiler_type_struct_member_array_stride(compiler, type, i, &stride) == SPVC_SUCCESS) {
            const char* name = spvc_compiler_get_name(compiler, spvc_type_get_base_type_id(member));
            for (ShaderStruct& known : structs)
                if (known.name == name) known.size = stride;  // the size of an array element
        }
    }
    structs.push_back(std::move(s));
}

bool memberFlag(const Module& m, const spvc_reflected_resource& r, SpvDecoration decoration) {
    return spvc_compiler_has_member_decoration(m.compiler, r.base_type_id, 0, decoration) ||
           spvc_compiler_has_decoration(m.compiler, r.id, decoration);
}

uint32_t texelWordsOf(SpvImageFormat format) {
    switch (format) {
        case SpvImageFormatR32ui:
            return 1;
        case SpvImageFormatRg32ui:
            return 2;
        case SpvImageFormatRgba32ui:
            return 4;
        default:
            return 0;
    }
}

}  // namespace

Status reflectShader(Shader& shader, uint32_t mostStorageBuffers) {
    DPL_TRY(Module m, openModule(shader, SPVC_BACKEND_NONE));
    if (shader.stage == ShaderStage::Compute)
        for (unsigned i = 0; i < 3; ++i)
            shader.workgroup[i] = spvc_compiler_get_execution_mode_argument_by_index(m.compiler, SpvExecutionModeLocalSize, i);
    for (spvc_resource_type type : {SPVC_RESOURCE_TYPE_UNIFORM_BUFFER, SPVC_RESOURCE_TYPE_STORAGE_BUFFER, SPVC_RESOURCE_TYPE_STORAGE_IMAGE,
                                    SPVC_RESOURCE_TYPE_SEPARATE_IMAGE}) {
        for (const spvc_reflected_resource& r : resourcesOf(m, type)) {
            if (spvc_compiler_get_decoration(m.compiler, r.id, SpvDecorationDescriptorSet) != 0)
                return fail(Code::InvalidArgument, "{}: {} must be in descriptor set 0", shader.name, r.name);
            ShaderBinding b;
            b.name = r.name;
            b.binding = spvc_compiler_get_decoration(m.compiler, r.id, SpvDecorationBinding);
            b.uniform = type == SPVC_RESOURCE_TYPE_UNIFORM_BUFFER;
            b.image = type == SPVC_RESOURCE_TYPE_SEPARATE_IMAGE;
            if (b.image) {
                spvc_type image = spvc_compiler_get_type_handle(m.compiler, r.type_id);
                if (spvc_type_get_image_dimension(image) != SpvDim2D)
                    return fail(Code::InvalidArgument, "{}: {} is not a two-dimensional texture", shader.name, r.name);
                b.reads = true;
                shader.bindings.push_back(std::move(b));
                continue;
            }
            b.writes = !b.uniform && !memberFlag(m, r, SpvDecorationNonWritable);
            b.reads = b.uniform || !memberFlag(m, r, SpvDecorationNonReadable);
            if (type == SPVC_RESOURCE_TYPE_STORAGE_IMAGE) {
                spvc_type image = spvc_compiler_get_type_handle(m.compiler, r.type_id);
                if (spvc_type_get_image_dimension(image) == SpvDimBuffer)
                    b.texelWords = texelWordsOf(spvc_type_get_image_storage_format(image));
                if (b.texelWords == 0 || b.writes)
                    return fail(Code::InvalidArgument, "{}: {} is not a read-only buffer of r32ui, rg32ui or rgba32ui", shader.name,
                                r.name);
                shader.bindings.push_back(std::move(b));
                continue;
            }
            shader.bindings.push_back(std::move(b));
            collectStructs(m.compiler, r.base_type_id, shader.structs);
        }
    }
    std::sort(shader.bindings.begin(), shader.bindings.end(), [](auto& a, auto& b) { return a.binding < b.binding; });
    const uint32_t first = shader.stage == ShaderStage::Fragment && !shader.bindings.empty() ? shader.bindings[0].binding
                                                                                             : 0;  // they follow those of its vertex stage
    for (uint32_t i = 0; i < shader.bindings.size(); ++i)
        if (shader.bindings[i].binding != first + i)
            return fail(Code::InvalidArgument, "{}: bindings must be 0, 1, 2 ... without gaps or duplicates", shader.name);
    const auto storage =
        std::count_if(shader.bindings.begin(), shader.bindings.end(), [](auto& b) { return !b.uniform && !b.image && b.texelWords == 0; });
    if (storage > mostStorageBuffers)
        return fail(Code::InvalidArgument, "{}: {} storage buffers, at most {} per stage", shader.name, storage, mostStorageBuffers);
    for (const spvc_reflected_resource& r : resourcesOf(m, SPVC_RESOURCE_TYPE_PUSH_CONSTANT)) {
        size_t size = 0;
        spvc_compiler_get_declared_struct_size(m.compiler, spvc_compiler_get_type_handle(m.compiler, r.base_type_id), &size);
        shader.pushBytes = uint32_t(size);
        collectStructs(m.compiler, r.base_type_id, shader.structs);
    }
    if (shader.pushBytes > 128)
        return fail(Code::InvalidArgument, "{}: {} push constant bytes, at most 128", shader.name, shader.pushBytes);
    return {};
}

Result<std::string> translateToMsl(const Shader& shader, MslPlatform platform, const MslOptions& wanted) {
    DPL_TRY(Module m, openModule(shader, SPVC_BACKEND_MSL));
    spvc_compiler_options options = nullptr;
    if (spvc_compiler_create_compiler_options(m.compiler, &options) != SPVC_SUCCESS) return m.error(shader.name);
    const bool ios = platform == MslPlatform::Ios;
    spvc_compiler_options_set_uint(options, SPVC_COMPILER_OPTION_MSL_VERSION, 20300);
    spvc_compiler_options_set_uint(options, SPVC_COMPILER_OPTION_MSL_PLATFORM, ios ? SPVC_MSL_PLATFORM_IOS : SPVC_MSL_PLATFORM_MACOS);
    if (ios) {
        spvc_compiler_options_set_bool(options, SPVC_COMPILER_OPTION_MSL_IOS_USE_SIMDGROUP_FUNCTIONS, SPVC_TRUE);
        spvc_compiler_options_set_bool(options, SPVC_COMPILER_OPTION_MSL_IOS_SUPPORT_BASE_VERTEX_INSTANCE, SPVC_TRUE);
    }
    if (shader.stage == ShaderStage::Vertex)
        spvc_compiler_options_set_bool(options, SPVC_COMPILER_OPTION_FLIP_VERTEX_Y, SPVC_TRUE);  // in Metal's clip space y points up
    if (wanted.eachSample) spvc_compiler_options_set_bool(options, SPVC_COMPILER_OPTION_MSL_FORCE_SAMPLE_RATE_SHADING, SPVC_TRUE);
    if (wanted.multiview) spvc_compiler_options_set_bool(options, SPVC_COMPILER_OPTION_MSL_MULTIVIEW, SPVC_TRUE);
    if (spvc_compiler_install_compiler_options(m.compiler, options) != SPVC_SUCCESS) return m.error(shader.name);

    const SpvExecutionModel model = spvc_compiler_get_execution_model(m.compiler);
    const auto map = [&](uint32_t set, uint32_t binding, uint32_t buffer) {
        spvc_msl_resource_binding b;
        spvc_msl_resource_binding_init(&b);
        b.stage = model, b.desc_set = set, b.binding = binding, b.msl_buffer = b.msl_texture = buffer;
        return spvc_compiler_msl_add_resource_binding(m.compiler, &b) == SPVC_SUCCESS;
    };
    for (const ShaderBinding& b : shader.bindings)
        if (!map(0, b.binding, b.binding)) return m.error(shader.name);
    if (!map(SPVC_MSL_PUSH_CONSTANT_DESC_SET, SPVC_MSL_PUSH_CONSTANT_BINDING, kMslPushBuffer)) return m.error(shader.name);
    const char* text = nullptr;
    if (spvc_compiler_compile(m.compiler, &text) != SPVC_SUCCESS) return m.error(shader.name);
    return std::string(text);
}

}  // namespace dpl
