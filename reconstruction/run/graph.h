// SPDX-License-Identifier: Apache-2.0
// A run as a graph: artefacts, each made by one stage from others. Whoever wants an artefact asks the run for it, and what it needs is made
// on the way.
//
//   template <> struct StageOf<RegisteredPoses> {
//       static constexpr StageName kName{"register", 8};
//       static constexpr const char* kPriors[] = {"subject/body", "subject/registration"};
//       static Status inputs(StageInputs& in);                       // pulls other artefacts and lists values
//       static Status make(StageInputs& in, StageContext& context);  // writes files into context.folder
//       static Result<RegisteredPoses> read(StageInputs& in, const std::filesystem::path& folder);
//   };
//   DPL_TRY(const RegisteredPoses* registered, run.get<RegisteredPoses>());
//
// The key of a stage is a hash of its name, its version, the priors of the rooms that it uses and what inputs() listed: the keys of
// artefacts that it uses whole, and values. make() and read() see only artefacts that inputs() pulled. The version must change when the
// code makes other files from the same inputs.
//
// A stage without files has `compute` in place of make and read; its value is made when somebody looks at it.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <typeindex>
#include <typeinfo>
#include <unordered_map>
#include <vector>

#include "reconstruction/run/priors_table.h"
#include "reconstruction/run/stage.h"
#include "sdk/core/jobs.h"

namespace dpl {

class StageInputs;

struct StageName {
    const char* name;
    uint32_t version;
};

/** How the artefact T is made; specialised beside T. */
template <class T>
struct StageOf;

/** Artefacts of one run, each made at most once. For use by one thread. Pointers to artefacts are valid as long as the run. */
class Run {
public:
    Run(StageChain& chain, Jobs& jobs, Progress& progress) : chain_(chain), jobs_(jobs), progress_(progress) {}
    Run(const Run&) = delete;
    Run& operator=(const Run&) = delete;

    /** The artefact. Its stage runs unless it is up to date. After an error the next call tries again. */
    template <class T>
    Result<const T*> get();

    /** Hash of everything that the artefact depends on. Makes its files, but a stage without files is not computed yet. */
    template <class T>
    Result<std::string> keyOf();

    /** Gives the run an artefact in place of the stage that makes it: what the user asked for, and truths that measurements put in. */
    template <class T>
    void put(T value, std::string key);

    StageChain& chain() { return chain_; }
    Jobs& jobs() { return jobs_; }
    Progress& progress() { return progress_; }

private:
    struct NodeBase {
        virtual ~NodeBase() = default;
        std::string key;
    };
    template <class T>
    struct Node : NodeBase {
        std::unique_ptr<StageInputs> inputs;  // null: the artefact was put
        std::filesystem::path folder;         // empty: a stage without files
        std::optional<T> value;
    };
    template <class T>
    Result<Node<T>*> node();
    template <class T>
    Result<Node<T>*> makeNode();

    StageChain& chain_;
    Jobs& jobs_;
    Progress& progress_;
    std::unordered_map<std::type_index, std::unique_ptr<NodeBase>> nodes_;
};

/** What a stage depends on: filled by its inputs(), read by the rest of it. */
class StageInputs {
public:
    explicit StageInputs(Run& run) : run_(run) {}

    /** Pulls an artefact whole: its key becomes an input, by the name of its stage. */
    template <class T>
    Status use() {
        DPL_TRY(const std::string key, run_.keyOf<T>());
        values_[StageOf<T>::kName.name] = key;
        pulled_.push_back(typeid(T));
        return {};
    }

    /** Pulls an artefact of which the stage uses parts. The caller lists them with value(); what is not listed must not decide anything. */
    template <class T>
    Result<const T*> part() {
        pulled_.push_back(typeid(T));
        return run_.get<T>();
    }

    /** Lists a value that the result depends on: settings, hashes of files. */
    void value(const char* name, nlohmann::json value) { values_[name] = std::move(value); }

    /** An artefact that inputs() pulled. Internal: it did not. */
    template <class T>
    Result<const T*> of() {
        if (!has<T>()) return fail(Code::Internal, "a stage looks at an artefact that its inputs do not pull ({})", typeid(T).name());
        return run_.get<T>();
    }

    /** Whether inputs() pulled it. */
    template <class T>
    bool has() const {
        for (const std::type_index& pulled : pulled_)
            if (pulled == typeid(T)) return true;
        return false;
    }

    Jobs& jobs() { return run_.jobs(); }
    Progress& progress() { return run_.progress(); }
    /** Where the results of the run lie. */
    const std::filesystem::path& outFolder() const { return run_.chain().outFolder(); }
    /** Whether an earlier run finished this stage, whatever its inputs were. */
    bool hasFinished(const char* stage) const { return run_.chain().hasFinished(stage); }
    /** Time and memory of the stages so far. */
    const std::vector<StageRecord>& records() const { return run_.chain().records(); }
    const nlohmann::json& values() const { return values_; }

private:
    Run& run_;
    nlohmann::json values_ = nlohmann::json::object();
    std::vector<std::type_index> pulled_;
};

template <class T>
Result<Run::Node<T>*> Run::makeNode() {
    using Stage = StageOf<T>;
    auto node = std::make_unique<Node<T>>();
    node->inputs = std::make_unique<StageInputs>(*this);
    DPL_RETURN_IF_ERROR(Stage::inputs(*node->inputs));
    if constexpr (requires { Stage::kPriors; }) node->inputs->value("priors", priorsOf(Stage::kPriors));
    if constexpr (requires { &Stage::make; }) {
        DPL_TRY(StageOutput made, chain_.run(Stage::kName.name, Stage::kName.version, node->inputs->values(),
                                             [&](StageContext& context) { return Stage::make(*node->inputs, context); }));
        node->key = std::move(made.key), node->folder = std::move(made.folder);
        if constexpr (requires { &Stage::keyAfter; }) {
            DPL_TRY(node->key, Stage::keyAfter(*node->inputs, node->folder, node->key));
        }
    } else {
        node->key = stageKey(Stage::kName.name, Stage::kName.version, node->inputs->values());
    }
    Node<T>* out = node.get();
    nodes_[typeid(T)] = std::move(node);
    return out;
}

template <class T>
Result<Run::Node<T>*> Run::node() {
    if (const auto found = nodes_.find(typeid(T)); found != nodes_.end()) return static_cast<Node<T>*>(found->second.get());
    return makeNode<T>();
}

template <class T>
Result<std::string> Run::keyOf() {
    DPL_TRY(const Node<T>* made, node<T>());
    return made->key;
}

template <class T>
Result<const T*> Run::get() {
    using Stage = StageOf<T>;
    DPL_TRY(Node<T>* const made, node<T>());
    if (!made->value) {
        if constexpr (requires { &Stage::make; }) {
            DPL_TRY(made->value, Stage::read(*made->inputs, made->folder));
        } else if constexpr (requires { &Stage::compute; }) {
            DPL_TRY(made->value, Stage::compute(*made->inputs));
        }
    }
    return &*made->value;
}

template <class T>
void Run::put(T value, std::string key) {
    auto node = std::make_unique<Node<T>>();
    node->key = std::move(key);
    node->value = std::move(value);
    nodes_[typeid(T)] = std::move(node);
}

}  // namespace dpl
