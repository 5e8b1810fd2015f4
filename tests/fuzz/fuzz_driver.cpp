// SPDX-License-Identifier: Apache-2.0
// A mutational fuzz driver for builds without libFuzzer: fuzz_driver CORPUS_DIR [--seconds N] [--runs N] [--seed N] [--first K].
// Runs every file of the corpus unchanged, then mutations of the files. Input k of a seed is the same in every run, so --seed S --first K
// repeats a crash. The driver prints both numbers before a long run and on exit.
#include <unistd.h>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace {

using Bytes = std::vector<uint8_t>;
volatile uint64_t currentInput = 0;
uint64_t currentSeed = 1;

void reportCrash(int signal) {
    char text[160];
    const int length =
        std::snprintf(text, sizeof(text), "\nfuzz: signal %d at input %llu; again with --seed %llu --first %llu --runs 1\n", signal,
                      (unsigned long long)currentInput, (unsigned long long)currentSeed, (unsigned long long)currentInput);
    if (write(2, text, size_t(length)) < 0) _exit(2);
    std::signal(signal, SIG_DFL);
    std::raise(signal);
}

std::vector<Bytes> loadCorpus(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        if (entry.is_regular_file() && entry.path().extension() != ".md") names.push_back(entry.path());
    std::sort(names.begin(), names.end());
    std::vector<Bytes> corpus;
    for (const auto& name : names) {
        std::ifstream in(name, std::ios::binary);
        corpus.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
    }
    return corpus;
}

class Mutator {
public:
    Mutator(const std::vector<Bytes>& corpus, uint64_t seed, uint64_t input) : corpus_(corpus), random_(seed * 1000003 + input) {}

    Bytes make() {
        Bytes bytes = corpus_[below(corpus_.size())];
        for (size_t rounds = 1 + below(4); rounds-- > 0 && !bytes.empty();) mutate(bytes);
        if (below(8) != 0) repairGlb(bytes);  // so that most inputs pass the checks of the container
        return bytes;
    }

private:
    size_t below(size_t n) { return size_t(random_() % std::max<size_t>(n, 1)); }

    void mutate(Bytes& bytes) {
        const size_t at = below(bytes.size());
        switch (below(8)) {
            case 0:
                bytes[at] ^= uint8_t(1 << below(8));
                break;
            case 1:
                bytes[at] = uint8_t(random_());
                break;
            case 2: {
                static constexpr uint32_t kWords[] = {0,          1,          0x7f,       0x80,       0xff,       0xffff,     0x10000,
                                                      0x7fffffff, 0x80000000, 0xffffffff, 0x7fc00000, 0x7f800000, 0xff800000, 0x00000001};
                const uint32_t word = kWords[below(std::size(kWords))];
                if (bytes.size() >= 4) std::memcpy(bytes.data() + std::min(at, bytes.size() - 4), &word, 4);
                break;
            }
            case 3:
                bytes.erase(bytes.begin() + ptrdiff_t(at), bytes.begin() + ptrdiff_t(std::min(bytes.size(), at + 1 + below(16))));
                break;
            case 4: {
                const Bytes copy(bytes.begin() + ptrdiff_t(at), bytes.begin() + ptrdiff_t(std::min(bytes.size(), at + 1 + below(64))));
                bytes.insert(bytes.begin() + ptrdiff_t(below(bytes.size())), copy.begin(), copy.end());
                break;
            }
            case 5: {
                const Bytes& other = corpus_[below(corpus_.size())];
                if (other.empty()) break;
                const size_t from = below(other.size()), count = std::min({other.size() - from, bytes.size() - at, 1 + below(256)});
                std::copy_n(other.begin() + ptrdiff_t(from), count, bytes.begin() + ptrdiff_t(at));
                break;
            }
            case 6:
                changeNumber(bytes, at);
                break;
            case 7:
                bytes.resize(at);
                break;
        }
    }

    /** Replaces the next number in the text, such as an index, count or offset in the JSON. */
    void changeNumber(Bytes& bytes, size_t from) {
        auto isDigit = [](uint8_t c) { return c >= '0' && c <= '9'; };
        auto begin = std::find_if(bytes.begin() + ptrdiff_t(from), bytes.end(), isDigit);
        auto end = std::find_if_not(begin, bytes.end(), isDigit);
        static const std::string kNumbers[] = {"0",
                                               "1",
                                               "2",
                                               "3",
                                               "7",
                                               "255",
                                               "256",
                                               "65535",
                                               "2147483647",
                                               "4294967296",
                                               "1099511627776",
                                               "-1",
                                               "1e30",
                                               "18446744073709551615"};
        const std::string& text = kNumbers[below(std::size(kNumbers))];
        begin = bytes.erase(begin, end);
        bytes.insert(begin, text.begin(), text.end());
    }

    /** Corrects the lengths: the JSON chunk ends at the last '}' before "BIN". */
    static void repairGlb(Bytes& bytes) {
        if (bytes.size() < 28 || bytes[0] != 'g') return;
        static constexpr uint8_t kBin[4] = {'B', 'I', 'N', 0};
        auto bin = std::search(bytes.begin() + 20, bytes.end(), std::begin(kBin), std::end(kBin));
        if (bin == bytes.end() || bin - bytes.begin() < 28) return;
        Bytes json(bytes.begin() + 20, bin - 4), data(bin + 4, bytes.end());
        while (json.size() % 4) json.push_back(' ');
        while (data.size() % 4) data.push_back(0);
        Bytes out(bytes.begin(), bytes.begin() + 20);
        auto word = [](Bytes& to, size_t at, size_t value) {
            const uint32_t w = uint32_t(value);
            std::memcpy(to.data() + at, &w, 4);
        };
        out.insert(out.end(), json.begin(), json.end());
        out.resize(out.size() + 8);
        word(out, out.size() - 8, data.size()), word(out, out.size() - 4, 0x004E4942);
        out.insert(out.end(), data.begin(), data.end());
        word(out, 8, out.size()), word(out, 12, json.size());
        bytes = std::move(out);
    }

    const std::vector<Bytes>& corpus_;
    std::mt19937_64 random_;
};

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2) {
        std::fprintf(stderr, "usage: %s CORPUS_DIR [--seconds N] [--runs N] [--seed N] [--first K]\n", argv[0]);
        return 2;
    }
    double seconds = 10;
    uint64_t runs = ~0ull, first = 0;
    for (int i = 2; i + 1 < argc; i += 2) {
        const std::string option = argv[i];
        if (option == "--seconds") seconds = std::atof(argv[i + 1]);
        if (option == "--runs") runs = std::strtoull(argv[i + 1], nullptr, 10);
        if (option == "--seed") currentSeed = std::strtoull(argv[i + 1], nullptr, 10);
        if (option == "--first") first = std::strtoull(argv[i + 1], nullptr, 10);
    }
    for (int signal : {SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL}) std::signal(signal, reportCrash);
    const std::vector<Bytes> corpus = loadCorpus(argv[1]);
    if (corpus.empty()) {
        std::fprintf(stderr, "fuzz: no corpus in %s\n", argv[1]);
        return 2;
    }
    for (const Bytes& bytes : corpus) LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
    const auto start = std::chrono::steady_clock::now();
    uint64_t done = 0;
    for (; done < runs; ++done) {
        if (std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() > seconds) break;
        currentInput = first + done;
        const Bytes bytes = Mutator(corpus, currentSeed, currentInput).make();
        LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
    }
    std::printf("fuzz: %zu corpus files, %llu mutations from seed %llu, no finding\n", corpus.size(), (unsigned long long)done,
                (unsigned long long)currentSeed);
    return 0;
}
