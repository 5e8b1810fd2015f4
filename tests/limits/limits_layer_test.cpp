// SPDX-License-Identifier: Apache-2.0
// The layer reports the phone's limits, and refuses each thing that goes beyond them. Every refusal stands beside the largest use that is
// still allowed.
#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include <vulkan/vulkan.h>

namespace {

constexpr VkResult kRefused = VK_ERROR_VALIDATION_FAILED_EXT;

class Instance {
public:
    /** layered: with the layer. Settings: "NAME=value". */
    explicit Instance(bool layered, std::initializer_list<const char*> settings = {}) {
        ::setenv("VK_ADD_LAYER_PATH", DOPPEL_LAYER_FOLDER, 1);
        ::setenv("VK_INSTANCE_LAYERS", layered ? "VK_LAYER_DOPPEL_limits" : "", 1);
        ::unsetenv("DOPPEL_PHONE_SUBGROUP");
        ::unsetenv("DOPPEL_PHONE_SAMPLE_SHADING");
        for (std::string setting : settings) {
            const size_t equals = setting.find('=');
            ::setenv(setting.substr(0, equals).c_str(), setting.c_str() + equals + 1, 1);
        }
        VkApplicationInfo app{VK_STRUCTURE_TYPE_APPLICATION_INFO};
        app.apiVersion = VK_API_VERSION_1_1;
        VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
        info.pApplicationInfo = &app;
        if (vkCreateInstance(&info, nullptr, &handle) != VK_SUCCESS) return;
        uint32_t count = 1;
        vkEnumeratePhysicalDevices(handle, &count, &physical);
    }
    ~Instance() {
        if (handle) vkDestroyInstance(handle, nullptr);
    }
    Instance(const Instance&) = delete;
    Instance& operator=(const Instance&) = delete;

    template <class T>
    T properties(VkStructureType type) const {
        T out{};
        out.sType = type;
        VkPhysicalDeviceProperties2 all{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &out, {}};
        vkGetPhysicalDeviceProperties2(physical, &all);
        return out;
    }
    VkPhysicalDeviceSubgroupProperties subgroups() const {
        return properties<VkPhysicalDeviceSubgroupProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES);
    }
    VkPhysicalDeviceProperties plain() const {
        VkPhysicalDeviceProperties out{};
        vkGetPhysicalDeviceProperties(physical, &out);
        return out;
    }
    VkPhysicalDeviceFeatures features() const {
        VkPhysicalDeviceFeatures out{};
        vkGetPhysicalDeviceFeatures(physical, &out);
        return out;
    }

    /** list: the structures of VkDeviceCreateInfo. */
    VkResult createDevice(VkDevice& device, const VkPhysicalDeviceFeatures* features = nullptr, const void* list = nullptr,
                          const char* extension = nullptr) const {
        const float priority = 1;
        VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
        queue.queueCount = 1;
        queue.pQueuePriorities = &priority;
        VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, list};
        info.queueCreateInfoCount = 1;
        info.pQueueCreateInfos = &queue;
        info.pEnabledFeatures = features;
        info.enabledExtensionCount = extension ? 1 : 0;
        info.ppEnabledExtensionNames = &extension;
        return vkCreateDevice(physical, &info, nullptr, &device);
    }

    VkInstance handle = VK_NULL_HANDLE;
    VkPhysicalDevice physical = VK_NULL_HANDLE;
};

/** A device on the phone. */
class LimitsLayer : public testing::Test {
protected:
    void SetUp() override {
        instance_.emplace(true);
        if (!instance_->physical) GTEST_SKIP() << "no Vulkan device here";
        ASSERT_EQ(instance_->createDevice(device_), VK_SUCCESS);
    }
    void TearDown() override {
        if (pool_) vkDestroyCommandPool(device_, pool_, nullptr);
        if (device_) vkDestroyDevice(device_, nullptr);
    }

    /** Runs `body` and expects that the layer printed a sentence with `text`; an empty text: that it printed nothing. */
    template <class Body>
    void expectSaid(const char* text, Body body) {
        testing::internal::CaptureStderr();
        body();
        const std::string said = testing::internal::GetCapturedStderr();
        if (*text == 0)
            EXPECT_EQ(said.find("limits layer:"), said.npos) << said;
        else
            EXPECT_NE(said.find(text), said.npos) << "said: " << said;
    }

    VkResult createLayout(uint32_t count, VkDescriptorType type, uint32_t pushBytes = 0, uint32_t sets = 1) {
        VkDescriptorSetLayoutBinding binding{0, type, count, VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
        VkDescriptorSetLayoutCreateInfo set{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
        set.bindingCount = 1;
        set.pBindings = &binding;
        VkDescriptorSetLayout setLayout = VK_NULL_HANDLE;
        EXPECT_EQ(vkCreateDescriptorSetLayout(device_, &set, nullptr, &setLayout), VK_SUCCESS);
        const std::vector<VkDescriptorSetLayout> all(sets, setLayout);
        const VkPushConstantRange push{VK_SHADER_STAGE_COMPUTE_BIT, 0, pushBytes};
        VkPipelineLayoutCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
        info.setLayoutCount = sets;
        info.pSetLayouts = all.data();
        info.pushConstantRangeCount = pushBytes ? 1 : 0;
        info.pPushConstantRanges = &push;
        VkPipelineLayout layout = VK_NULL_HANDLE;
        const VkResult result = vkCreatePipelineLayout(device_, &info, nullptr, &layout);
        vkDestroyPipelineLayout(device_, layout, nullptr);
        vkDestroyDescriptorSetLayout(device_, setLayout, nullptr);
        return result;
    }

    VkResult createShader(std::vector<uint32_t> body) {
        std::vector<uint32_t> words = {0x07230203, 0x00010300, 0, 16, 0};
        words.insert(words.end(), body.begin(), body.end());
        words.insert(words.end(), {3u << 16 | 14, 0, 1});  // OpMemoryModel Logical GLSL450
        VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
        info.codeSize = words.size() * 4;
        info.pCode = words.data();
        VkShaderModule module = VK_NULL_HANDLE;
        const VkResult result = vkCreateShaderModule(device_, &info, nullptr, &module);
        vkDestroyShaderModule(device_, module, nullptr);
        return result;
    }
    VkResult createShaderWith(uint32_t capability) { return createShader({2u << 16 | 17, 1, 2u << 16 | 17, capability}); }

    /** Records what `record` does, and returns the result of vkEndCommandBuffer. */
    template <class Record>
    VkResult recorded(Record record) {
        if (!pool_) {
            const VkCommandPoolCreateInfo info{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
            EXPECT_EQ(vkCreateCommandPool(device_, &info, nullptr, &pool_), VK_SUCCESS);
        }
        VkCommandBufferAllocateInfo allocation{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
        allocation.commandPool = pool_;
        allocation.commandBufferCount = 1;
        VkCommandBuffer commands = VK_NULL_HANDLE;
        EXPECT_EQ(vkAllocateCommandBuffers(device_, &allocation, &commands), VK_SUCCESS);
        const VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
        EXPECT_EQ(vkBeginCommandBuffer(commands, &begin), VK_SUCCESS);
        record(commands);
        return vkEndCommandBuffer(commands);
    }

    /** Writes a storage buffer descriptor with `range` bytes of a buffer of `bytes`; returns what the next vkEndCommandBuffer says. */
    VkResult bind(VkDescriptorType type, VkDeviceSize bytes, VkDeviceSize range) {
        VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
        info.size = bytes;
        info.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT;
        VkBuffer buffer = VK_NULL_HANDLE;
        EXPECT_EQ(vkCreateBuffer(device_, &info, nullptr, &buffer), VK_SUCCESS);
        VkMemoryRequirements needs{};
        vkGetBufferMemoryRequirements(device_, buffer, &needs);
        VkMemoryAllocateInfo allocation{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
        allocation.allocationSize = needs.size;
        while (!(needs.memoryTypeBits >> allocation.memoryTypeIndex & 1)) ++allocation.memoryTypeIndex;
        VkDeviceMemory memory = VK_NULL_HANDLE;
        EXPECT_EQ(vkAllocateMemory(device_, &allocation, nullptr, &memory), VK_SUCCESS);
        EXPECT_EQ(vkBindBufferMemory(device_, buffer, memory, 0), VK_SUCCESS);

        const VkDescriptorSetLayoutBinding binding{0, type, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
        VkDescriptorSetLayoutCreateInfo setInfo{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
        setInfo.bindingCount = 1;
        setInfo.pBindings = &binding;
        VkDescriptorSetLayout layout = VK_NULL_HANDLE;
        EXPECT_EQ(vkCreateDescriptorSetLayout(device_, &setInfo, nullptr, &layout), VK_SUCCESS);
        const VkDescriptorPoolSize size{type, 1};
        VkDescriptorPoolCreateInfo poolInfo{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
        poolInfo.maxSets = 1;
        poolInfo.poolSizeCount = 1;
        poolInfo.pPoolSizes = &size;
        VkDescriptorPool descriptors = VK_NULL_HANDLE;
        EXPECT_EQ(vkCreateDescriptorPool(device_, &poolInfo, nullptr, &descriptors), VK_SUCCESS);
        VkDescriptorSetAllocateInfo setAllocation{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
        setAllocation.descriptorPool = descriptors;
        setAllocation.descriptorSetCount = 1;
        setAllocation.pSetLayouts = &layout;
        VkDescriptorSet set = VK_NULL_HANDLE;
        EXPECT_EQ(vkAllocateDescriptorSets(device_, &setAllocation, &set), VK_SUCCESS);
        const VkDescriptorBufferInfo bound{buffer, 0, range};
        VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
        write.dstSet = set;
        write.descriptorCount = 1;
        write.descriptorType = type;
        write.pBufferInfo = &bound;
        vkUpdateDescriptorSets(device_, 1, &write, 0, nullptr);
        const VkResult result = recorded([](VkCommandBuffer) {});
        vkDestroyDescriptorPool(device_, descriptors, nullptr);
        vkDestroyDescriptorSetLayout(device_, layout, nullptr);
        vkDestroyBuffer(device_, buffer, nullptr);
        vkFreeMemory(device_, memory, nullptr);
        return result;
    }

    std::optional<Instance> instance_;
    VkDevice device_ = VK_NULL_HANDLE;
    VkCommandPool pool_ = VK_NULL_HANDLE;
};

TEST_F(LimitsLayer, reportsAPhone) {
    const VkPhysicalDeviceProperties phone = instance_->plain();
    EXPECT_EQ(phone.limits.maxPerStageDescriptorStorageBuffers, 4u);
    EXPECT_EQ(phone.limits.maxPushConstantsSize, 128u);
    EXPECT_EQ(phone.limits.maxStorageBufferRange, 128u << 20);
    EXPECT_EQ(phone.limits.maxComputeWorkGroupCount[0], 65535u);
    EXPECT_EQ(VK_API_VERSION_MINOR(phone.apiVersion), 1u);
    EXPECT_NE(std::string(phone.deviceName).find("phone of 2020 on "), std::string::npos) << phone.deviceName;
    uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(instance_->physical, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vkGetPhysicalDeviceQueueFamilyProperties(instance_->physical, &count, families.data());
    for (const VkQueueFamilyProperties& family : families) EXPECT_EQ(family.timestampValidBits, 0u);
    VkPhysicalDeviceShaderFloat16Int8Features half{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_FLOAT16_INT8_FEATURES};
    VkPhysicalDeviceMultiviewFeatures multiview{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MULTIVIEW_FEATURES, &half};
    VkPhysicalDeviceFeatures2 features{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &multiview};
    vkGetPhysicalDeviceFeatures2(instance_->physical, &features);
    EXPECT_FALSE(half.shaderFloat16);
    EXPECT_FALSE(multiview.multiview);
    EXPECT_FALSE(features.features.shaderFloat64);
    uint32_t extensionCount = 0;
    vkEnumerateDeviceExtensionProperties(instance_->physical, nullptr, &extensionCount, nullptr);
    std::vector<VkExtensionProperties> extensions(extensionCount);
    vkEnumerateDeviceExtensionProperties(instance_->physical, nullptr, &extensionCount, extensions.data());
    for (const VkExtensionProperties& e : extensions) EXPECT_STRNE(e.extensionName, "VK_KHR_shader_float16_int8");
}

TEST_F(LimitsLayer, neverReportsMoreThanTheDriver) {
    const Instance driver(false);
    const VkPhysicalDeviceLimits own = driver.plain().limits, phone = instance_->plain().limits;
    EXPECT_LE(phone.maxPerStageDescriptorStorageBuffers, own.maxPerStageDescriptorStorageBuffers);
    EXPECT_LE(phone.maxStorageBufferRange, own.maxStorageBufferRange);
    EXPECT_LE(phone.maxComputeWorkGroupInvocations, own.maxComputeWorkGroupInvocations);
    EXPECT_EQ(phone.minStorageBufferOffsetAlignment, own.minStorageBufferOffsetAlignment) << "other limits are the driver's";
    const VkPhysicalDeviceFeatures ownFeatures = driver.features(), phoneFeatures = instance_->features();
    const auto *mine = reinterpret_cast<const VkBool32*>(&ownFeatures), *theirs = reinterpret_cast<const VkBool32*>(&phoneFeatures);
    for (size_t i = 0; i < sizeof ownFeatures / sizeof(VkBool32); ++i) EXPECT_LE(theirs[i], mine[i]) << "member " << i;
}

TEST_F(LimitsLayer, aSizeThatIsPlayedHasNoSubgroupOperations) {
    const uint32_t own = instance_->subgroups().subgroupSize;
    EXPECT_NE(instance_->subgroups().supportedOperations, 0u) << "the driver's own size keeps its operations";
    for (uint32_t size : {4u, 8u, 64u, 128u}) {
        const Instance phone(true, {("DOPPEL_PHONE_SUBGROUP=" + std::to_string(size)).c_str()});
        const VkPhysicalDeviceSubgroupProperties subgroups = phone.subgroups();
        EXPECT_EQ(subgroups.subgroupSize, size);
        EXPECT_EQ(subgroups.supportedOperations != 0, size == own) << size;
        EXPECT_EQ(subgroups.supportedStages != 0, size == own) << size;
    }
}

TEST_F(LimitsLayer, refusesAFifthStorageBufferInAStage) {
    for (const VkDescriptorType type : {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER_DYNAMIC}) {
        expectSaid("", [&] { EXPECT_EQ(createLayout(4, type), VK_SUCCESS); });
        expectSaid("vkCreatePipelineLayout has 5 storage buffers in shader stage 0x20, the device reports 4",
                   [&] { EXPECT_EQ(createLayout(5, type), kRefused); });
    }
    expectSaid("has 6 storage buffers",
               [&] { EXPECT_EQ(createLayout(3, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 0, 2), kRefused) << "two sets"; });
}

TEST_F(LimitsLayer, refusesOtherDescriptorsAboveTheirLimit) {
    expectSaid("", [&] { EXPECT_EQ(createLayout(12, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER), VK_SUCCESS); });
    expectSaid("13 uniform buffers", [&] { EXPECT_EQ(createLayout(13, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER), kRefused); });
    expectSaid("", [&] { EXPECT_EQ(createLayout(4, VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER), VK_SUCCESS); });
    expectSaid("5 storage images", [&] { EXPECT_EQ(createLayout(5, VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER), kRefused); });
    expectSaid("17 sampled images", [&] { EXPECT_EQ(createLayout(17, VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE), kRefused); });
    expectSaid("5 descriptor sets", [&] { EXPECT_EQ(createLayout(0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 0, 5), kRefused); });
}

TEST_F(LimitsLayer, refusesPushConstantsAbove128Bytes) {
    expectSaid("", [&] { EXPECT_EQ(createLayout(1, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 128), VK_SUCCESS); });
    expectSaid("push constants up to byte 132, the device reports 128",
               [&] { EXPECT_EQ(createLayout(1, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 132), kRefused); });
}

TEST_F(LimitsLayer, refusesBindingsAboveTheirRange) {
    const VkDeviceSize limit = 128u << 20;
    expectSaid("", [&] { EXPECT_EQ(bind(VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, limit + 16, limit), VK_SUCCESS); });
    expectSaid("binds 134217732 bytes of a storage buffer, the device reports 134217728",
               [&] { EXPECT_EQ(bind(VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, limit + 16, limit + 4), kRefused); });
    expectSaid("binds 134217744 bytes", [&] { EXPECT_EQ(bind(VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, limit + 16, VK_WHOLE_SIZE), kRefused); });
    expectSaid("binds 16388 bytes of a uniform buffer",
               [&] { EXPECT_EQ(bind(VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 32768, 16388), kRefused); });
    expectSaid("", [&] { EXPECT_EQ(recorded([](VkCommandBuffer) {}), VK_SUCCESS) << "a refusal does not stick"; });
}

TEST_F(LimitsLayer, refusesDispatchesOfTooManyGroups) {
    expectSaid("", [&] { EXPECT_EQ(recorded([](VkCommandBuffer c) { vkCmdDispatch(c, 65535, 1, 1); }), VK_SUCCESS); });
    expectSaid("65536 workgroups along x, the device reports 65535",
               [&] { EXPECT_EQ(recorded([](VkCommandBuffer c) { vkCmdDispatch(c, 65536, 1, 1); }), kRefused); });
    expectSaid("70000 workgroups along z",
               [&] { EXPECT_EQ(recorded([](VkCommandBuffer c) { vkCmdDispatch(c, 1, 1, 70000); }), kRefused); });
    expectSaid("65536 workgroups along y",
               [&] { EXPECT_EQ(recorded([](VkCommandBuffer c) { vkCmdDispatchBase(c, 0, 0, 0, 1, 65536, 1); }), kRefused); });
}

TEST_F(LimitsLayer, refusesTimestamps) {
    VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
    info.queryType = VK_QUERY_TYPE_TIMESTAMP;
    info.queryCount = 1;
    VkQueryPool queries = VK_NULL_HANDLE;
    ASSERT_EQ(vkCreateQueryPool(device_, &info, nullptr, &queries), VK_SUCCESS);
    expectSaid("a timestamp is written", [&] {
        EXPECT_EQ(recorded([&](VkCommandBuffer c) { vkCmdWriteTimestamp(c, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queries, 0); }), kRefused);
    });
    vkDestroyQueryPool(device_, queries, nullptr);
}

TEST_F(LimitsLayer, refusesShadersThatNeedMore) {
    expectSaid("", [&] { EXPECT_EQ(createShaderWith(1), VK_SUCCESS); });
    expectSaid("without shaderFloat16", [&] { EXPECT_EQ(createShaderWith(9), kRefused); });
    expectSaid("without shaderInt64", [&] { EXPECT_EQ(createShaderWith(11), kRefused); });
    expectSaid("without sampleRateShading", [&] { EXPECT_EQ(createShaderWith(35), kRefused) << "reported, but not enabled"; });
    expectSaid("without shaderStorageImageExtendedFormats", [&] { EXPECT_EQ(createShaderWith(49), kRefused); });
    expectSaid("without multiview", [&] { EXPECT_EQ(createShaderWith(4439), kRefused); });
    expectSaid("does not know", [&] { EXPECT_EQ(createShaderWith(5000), kRefused); });
    const auto lanes = [](uint32_t x) { return std::vector<uint32_t>{2u << 16 | 17, 1, 6u << 16 | 16, 1, 17, x, 1, 1}; };
    expectSaid("", [&] { EXPECT_EQ(createShader(lanes(256)), VK_SUCCESS); });
    expectSaid("workgroups of 257 invocations, the device reports 256", [&] { EXPECT_EQ(createShader(lanes(257)), kRefused); });
}

TEST_F(LimitsLayer, refusesSubgroupShadersWhereTheSizeIsPlayed) {
    expectSaid("", [&] { EXPECT_EQ(createShaderWith(61), VK_SUCCESS) << "the driver's own subgroups"; });
    const uint32_t own = instance_->subgroups().subgroupSize;
    const Instance phone(true, {own == 64 ? "DOPPEL_PHONE_SUBGROUP=4" : "DOPPEL_PHONE_SUBGROUP=64"});
    vkDestroyDevice(device_, nullptr);
    ASSERT_EQ(phone.createDevice(device_), VK_SUCCESS);
    for (uint32_t capability : {61u, 65u})
        expectSaid("without subgroup operations", [&] { EXPECT_EQ(createShaderWith(capability), kRefused); });
    vkDestroyDevice(device_, nullptr);
    device_ = VK_NULL_HANDLE;
}

TEST_F(LimitsLayer, refusesFeaturesAndExtensionsThatAreNotReported) {
    VkDevice device = VK_NULL_HANDLE;
    VkPhysicalDeviceFeatures features{};
    features.shaderFloat64 = VK_TRUE;
    expectSaid("enables member", [&] { EXPECT_EQ(instance_->createDevice(device, &features), kRefused); });
    VkPhysicalDeviceFeatures2 features2{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, nullptr, features};
    expectSaid("enables member", [&] { EXPECT_EQ(instance_->createDevice(device, nullptr, &features2), kRefused); });
    VkPhysicalDeviceMultiviewFeatures multiview{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MULTIVIEW_FEATURES};
    multiview.multiview = VK_TRUE;
    expectSaid("enables boolean 0", [&] { EXPECT_EQ(instance_->createDevice(device, nullptr, &multiview), kRefused); });
    VkPhysicalDeviceShaderFloat16Int8Features half{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_FLOAT16_INT8_FEATURES};
    half.shaderFloat16 = VK_TRUE;
    expectSaid("enables boolean 0", [&] { EXPECT_EQ(instance_->createDevice(device, nullptr, &half), kRefused); });
    VkPhysicalDeviceVulkan12Features later{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
    later.hostQueryReset = VK_TRUE;
    expectSaid("enables boolean", [&] { EXPECT_EQ(instance_->createDevice(device, nullptr, &later), kRefused); });
    VkPhysicalDeviceInlineUniformBlockFeatures unknown{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_INLINE_UNIFORM_BLOCK_FEATURES};
    expectSaid("does not know", [&] { EXPECT_EQ(instance_->createDevice(device, nullptr, &unknown), kRefused); });
    EXPECT_EQ(instance_->createDevice(device, nullptr, nullptr, "VK_KHR_multiview"), VK_ERROR_EXTENSION_NOT_PRESENT);
    multiview.multiview = VK_FALSE;
    expectSaid("", [&] {
        ASSERT_EQ(instance_->createDevice(device, nullptr, &multiview), VK_SUCCESS) << "a structure that enables nothing";
        vkDestroyDevice(device, nullptr);
    });
}

TEST_F(LimitsLayer, refusesViewsAndSamplesThatWereNotEnabled) {
    const uint32_t views = 3;
    VkRenderPassMultiviewCreateInfo multiview{VK_STRUCTURE_TYPE_RENDER_PASS_MULTIVIEW_CREATE_INFO};
    multiview.subpassCount = 1;
    multiview.pViewMasks = &views;
    VkSubpassDescription subpass{};
    VkRenderPassCreateInfo pass{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO, &multiview};
    pass.subpassCount = 1;
    pass.pSubpasses = &subpass;
    VkRenderPass made = VK_NULL_HANDLE;
    expectSaid("without multiview", [&] { EXPECT_EQ(vkCreateRenderPass(device_, &pass, nullptr, &made), kRefused); });
    VkPipelineMultisampleStateCreateInfo samples{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
    samples.rasterizationSamples = VK_SAMPLE_COUNT_4_BIT;
    samples.sampleShadingEnable = VK_TRUE;
    VkGraphicsPipelineCreateInfo pipeline{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO};
    pipeline.pMultisampleState = &samples;
    VkPipeline none = VK_NULL_HANDLE;
    expectSaid("without sampleRateShading",
               [&] { EXPECT_EQ(vkCreateGraphicsPipelines(device_, VK_NULL_HANDLE, 1, &pipeline, nullptr, &none), kRefused); });
}

TEST_F(LimitsLayer, sampleShadingCanBeOff) {
    const Instance phone(true, {"DOPPEL_PHONE_SAMPLE_SHADING=0"});
    EXPECT_FALSE(phone.features().sampleRateShading);
    VkPhysicalDeviceFeatures features{};
    features.sampleRateShading = VK_TRUE;
    VkDevice device = VK_NULL_HANDLE;
    expectSaid("enables member", [&] { EXPECT_EQ(phone.createDevice(device, &features), kRefused); });
}

TEST_F(LimitsLayer, refusesSeveralDrawsInOneCall) {
    VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    info.size = 64;
    info.usage = VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT;
    VkBuffer buffer = VK_NULL_HANDLE;
    ASSERT_EQ(vkCreateBuffer(device_, &info, nullptr, &buffer), VK_SUCCESS);
    expectSaid("2 draws", [&] { EXPECT_EQ(recorded([&](VkCommandBuffer c) { vkCmdDrawIndirect(c, buffer, 0, 2, 16); }), kRefused); });
    expectSaid("", [&] { EXPECT_EQ(recorded([&](VkCommandBuffer c) { vkCmdDrawIndirect(c, buffer, 0, 1, 16); }), VK_SUCCESS); });
    vkDestroyBuffer(device_, buffer, nullptr);
}

}  // namespace
