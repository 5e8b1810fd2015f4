// SPDX-License-Identifier: Apache-2.0
// Where the person of a scan is in each of its pictures. Private to reconstruction/input/capture.
#pragma once

#include "reconstruction/input/observe/choose_person.h"

namespace dpl {

/** Where the person is looked for in one frame. */
struct Whereabouts {
    std::vector<SeenPerson> people;
    size_t chosen = kNobody;
    std::optional<PersonCrop> start;  // of the chosen person; between neighbours that see the person, where those say
};

/** Chooses in the frames of one kind. `order`: the frames as they were taken, indices into `where`, which holds the people of every frame.
 *  Held-out frames take whom their neighbours in training say, and decide nothing. */
void choosePlaces(const Scan& scan, std::span<const size_t> order, std::span<const PersonPoint> points, std::vector<Whereabouts>& where);

/** people.json: the boxes of all people of each frame, and which was chosen. */
std::string placesJson(const Scan& scan, const std::vector<Whereabouts>& where);

/** What was chosen, for the log; empty where there was no choice. */
std::string describePlaces(const Scan& scan, const std::vector<Whereabouts>& where);

}  // namespace dpl
