// SPDX-License-Identifier: Apache-2.0
// The two subjects of these tests. Each is made once, because that takes seconds.
#pragma once

#include "reconstruction/sample/subject.h"

namespace dpl {

inline const Subject& subject() {
    static const Subject kSubject = [] {
        Jobs jobs(2);
        return makeSubject(6, jobs);  // the hair of this seed needs a pinhole closed beside the hairline
    }();
    return kSubject;
}

inline const Subject& skirted() {
    static const Subject kSubject = [] {
        Jobs jobs(2);
        return makeSubject(6, jobs, Bottom::Skirt);
    }();
    return kSubject;
}

}  // namespace dpl
