// SPDX-License-Identifier: Apache-2.0
// Which label the clothed surface carries: votes of the still pictures per vertex, smoothed, small islands removed.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "reconstruction/subject/garments/still_views.h"
#include "reconstruction/subject/shape/implicit_mesh.h"
#include "sdk/core/jobs.h"
#include "sdk/core/result.h"

namespace dpl {

/** Scores of C labels at V vertices. Column 0 is the body. */
struct LabelField {
    std::vector<ScanLabel> labels;  // C: of the columns
    std::vector<float> score;       // V × C, row by row; each row sums to 1
    std::vector<float> seen;        // V: how many pixels saw the vertex, smoothed like the scores; 1 is the median of seen vertices

    size_t columns() const { return labels.size(); }
    uint32_t best(size_t vertex) const;  // the column with the highest score; the lower column wins ties
};

/** The labels that vote: all of the scan but background, the body's first. A scan without a label "body" gets one, with the lowest value
 *  that is free. */
std::vector<ScanLabel> votingLabels(std::span<const ScanLabel> labels);

/** Each person pixel votes for its label at the corners of the triangle that it sees from the front, weighted by the cosine of the viewing
 *  angle. Then the votes are spread over the surface by about smoothingM (LargeSteps). Vertices without votes near them take the label of
 *  the nearest ones. `cameras`: one per view, without sway. Errors: LargeSteps refuses the mesh. */
Result<LabelField> voteLabels(const SurfaceMesh& mesh, std::span<const GarmentView> views, std::span<const Camerad> cameras,
                              std::span<const ScanLabel> scanLabels, double smoothingM, Jobs& jobs);

/** Gives islands of a label to the label around them: connected pieces of column c below minAreaM2[c]. An infinite area removes a label
 *  wherever another one is beside it. */
void removeIslands(const SurfaceMesh& mesh, LabelField& field, std::span<const double> minAreaM2);

/** Area of the surface around each vertex: a third of its triangles', m². */
std::vector<float> vertexAreas(const SurfaceMesh& mesh);

}  // namespace dpl
