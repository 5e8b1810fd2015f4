// SPDX-License-Identifier: Apache-2.0
#include "sdk/backend/null/null_backend.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <set>

#include "sdk/backend/frame_check.h"

namespace dpl {
namespace {

class NullBackend final : public Backend, private ResourceView {
public:
    NullBackend(ShaderPack pack, std::shared_ptr<NullRecord> record, DeviceInfo info)
        : pack_(std::move(pack)), record_(std::move(record)), info_(std::move(info)) {}

    const DeviceInfo& info() const override { return info_; }

    Result<BufferId> createBuffer(const BufferDesc& desc) override {
        if (desc.bytes == 0) return fail(Code::InvalidArgument, "buffer {} has no bytes", desc.label);
        Buffer b{desc, {}, false};
        if (desc.memory != BufferMemory::Device) b.bytes.resize(desc.bytes);
        buffers_.emplace(++lastId_, std::move(b));
        ++record_->liveBuffers, ++record_->createdObjects;
        return BufferId{lastId_};
    }
    void destroyBuffer(BufferId id) override { record_->liveBuffers -= buffers_.erase(id.value); }

    Status write(BufferId id, uint64_t offset, std::span<const std::byte> bytes) override {
        const auto it = buffers_.find(id.value);
        if (it == buffers_.end() || offset + bytes.size() > it->second.desc.bytes)
            return fail(Code::InvalidArgument, "the write does not fit the buffer");
        it->second.written = true;
        return {};
    }
    Result<uint64_t> queueCopy(BufferId from, uint64_t, BufferId to, uint64_t toOffset, uint64_t bytes) override {
        const auto it = buffers_.find(to.value);
        if (!buffers_.count(from.value) || it == buffers_.end() || toOffset + bytes > it->second.desc.bytes)
            return fail(Code::InvalidArgument, "the copy does not fit the buffer");
        it->second.written = true;
        return 1;
    }
    Result<bool> hasRun(uint64_t) override { return true; }
    std::span<std::byte> mapped(BufferId id) override {
        const auto it = buffers_.find(id.value);
        return it == buffers_.end() ? std::span<std::byte>() : std::span<std::byte>(it->second.bytes);
    }

    Result<PipelineId> computePipeline(std::string_view name) override { return pipeline(name); }
    Result<PipelineId> drawPipeline(const DrawPipelineDesc& desc) override {
        const Shader *vertex = pack_.find(desc.vertex), *fragment = pack_.find(desc.fragment);
        if (!vertex || !fragment) return fail(Code::NotFound, "no shader {} or {} in the pack", desc.vertex, desc.fragment);
        const auto known = std::find(draws_.begin(), draws_.end(), std::pair(vertex, fragment));
        const size_t index = size_t(known - draws_.begin());
        if (known == draws_.end()) draws_.emplace_back(vertex, fragment);
        return PipelineId{uint32_t(pack_.shaders.size() + index) + 1};
    }
    uint32_t workgroupSize(PipelineId id) const override { return shader(id) ? shader(id)->workgroup[0] : 0; }

    Result<TargetId> createTarget(const TargetDesc& desc) override {
        if (desc.samples != 1 && !(desc.samples == 4 && info_.fourSamples))
            return fail(Code::Unsupported, "{} samples a pixel are not possible on this device", desc.samples);
        if (desc.widthPx == 0 || desc.heightPx == 0 || desc.widthPx > info_.maxTargetPx || desc.heightPx > info_.maxTargetPx)
            return fail(Code::Unsupported, "a picture of {} x {} px is not possible; this device draws 1 to {} px a side", desc.widthPx,
                        desc.heightPx, info_.maxTargetPx);
        targets_.emplace(++lastId_, desc);
        ++record_->liveTargets, ++record_->createdObjects;
        return TargetId{lastId_};
    }
    void destroyTarget(TargetId id) override { record_->liveTargets -= targets_.erase(id.value); }

    Result<FrameId> createFrame(std::vector<Step> steps, FrameRun) override {
        DPL_RETURN_IF_ERROR(checkFrame(steps, *this, info_));
        for (const Step& step : steps)
            if (const auto* draw = std::get_if<DrawStep>(&step)) drawn_.insert(draw->target.value);
        for (const BufferId id : writtenBy(steps)) buffers_.at(id.value).written = true;
        frames_.emplace(++lastId_, std::move(steps));
        ++record_->liveFrames, ++record_->createdObjects;
        return FrameId{lastId_};
    }
    void destroyFrame(FrameId id) override {
        running_.erase(id.value);
        record_->liveFrames -= frames_.erase(id.value);
    }

    Status submit(FrameId id) override {
        const auto it = frames_.find(id.value);
        if (it == frames_.end()) return fail(Code::InvalidArgument, "the submitted frame does not exist");
        DPL_RETURN_IF_ERROR(wait(id));
        // Refuses a frame whose buffers were destroyed after it was created.
        DPL_RETURN_IF_ERROR(checkFrame(it->second, *this, info_));
        record_->lastLabels.clear();
        for (const Step& step : it->second) record_->lastLabels.push_back(stepLabel(step));
        ++record_->runs;
        if (record_->holdFrames) running_.insert(id.value);
        return {};
    }
    Status encode(FrameId id, uint32_t, AppCommands) override { return submit(id); }
    bool finished(FrameId id) override { return !running_.count(id.value); }
    Status wait(FrameId id) override {
        record_->waits += running_.erase(id.value);
        return {};
    }
    std::vector<PassTime> passTimes(FrameId) override { return {}; }
    double frameMs(FrameId) override { return record_->frameMs; }

    uint64_t residentBytes() const override {
        uint64_t bytes = 0;
        for (const auto& [id, b] : buffers_) bytes += b.desc.bytes;
        return bytes;
    }

private:
    struct Buffer {
        BufferDesc desc;
        std::vector<std::byte> bytes;
        bool written = false;
    };

    Result<PipelineId> pipeline(std::string_view name) {
        const Shader* shader = pack_.find(name);
        if (!shader) return fail(Code::NotFound, "no shader {} in the pack", name);
        return PipelineId{uint32_t(shader - pack_.shaders.data()) + 1};
    }

    const BufferDesc* buffer(BufferId id) const override {
        const auto it = buffers_.find(id.value);
        return it == buffers_.end() ? nullptr : &it->second.desc;
    }
    const TargetDesc* target(TargetId id) const override {
        const auto it = targets_.find(id.value);
        return it == targets_.end() ? nullptr : &it->second;
    }
    const Shader* shader(PipelineId id) const override {
        if (id.value == 0) return nullptr;
        const size_t index = id.value - 1, shaders = pack_.shaders.size();
        return index < shaders ? &pack_.shaders[index] : index - shaders < draws_.size() ? draws_[index - shaders].first : nullptr;
    }
    const Shader* fragment(PipelineId id) const override {
        const size_t shaders = pack_.shaders.size();
        return id.value <= shaders || id.value - 1 - shaders >= draws_.size() ? nullptr : draws_[id.value - 1 - shaders].second;
    }
    bool written(BufferId id) const override { return buffers_.at(id.value).written; }
    bool drawn(TargetId id) const override { return drawn_.count(id.value) > 0; }

    ShaderPack pack_;
    std::shared_ptr<NullRecord> record_;
    DeviceInfo info_;
    std::vector<std::pair<const Shader*, const Shader*>> draws_;  // vertex, fragment; their ids follow those of the pack's shaders
    std::map<uint32_t, Buffer> buffers_;
    std::map<uint32_t, TargetDesc> targets_;
    std::map<uint32_t, std::vector<Step>> frames_;
    std::set<uint32_t> drawn_, running_;
    uint32_t lastId_ = 0;
};

}  // namespace

Result<std::unique_ptr<Backend>> createNullBackend(std::shared_ptr<NullRecord> record, const NullOptions& options) {
    DPL_TRY(ShaderPack pack, readShaderPack(embeddedShaderPack(), "the embedded shader pack", embeddedShaderInterface()));
    if (!record) record = std::make_shared<NullRecord>();
    return std::unique_ptr<Backend>(std::make_unique<NullBackend>(std::move(pack), std::move(record), options.info));
}

}  // namespace dpl
