// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/dressing.h"

namespace dpl {

bool canDress(const ViewedSubject& subject) {
    return subject.isAvatar() && !subject.path.empty();
}

std::vector<std::string> dressArguments(const std::filesystem::path& program, const ViewedSubject& wearer, const Outfit& outfit,
                                        const std::vector<ViewedSubject>& subjects, const std::filesystem::path& out) {
    std::vector<std::string> words = {program.string(), "dress", wearer.path.string(), "-o", out.string()};
    const size_t before = words.size();
    for (size_t i = 0; i < kGarments.size(); ++i)
        for (const ViewedSubject& giver : subjects)
            if (outfit[i] && giver.avatar.handle() == outfit[i] && canDress(giver))
                words.insert(words.end(), {std::string("--") + kGarments[i], giver.path.string()});
    return words.size() == before ? std::vector<std::string>() : words;
}

}  // namespace dpl
