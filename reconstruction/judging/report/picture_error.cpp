// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/report/picture_error.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace dpl {

double psnrDb(double meanSquare) {
    return meanSquare > 0 ? std::min(kEqualPsnrDb, -10 * std::log10(meanSquare)) : kEqualPsnrDb;
}

cv::Mat ssimMap(const cv::Mat& a, const cv::Mat& b) {
    const auto blur = [](const cv::Mat& in) {
        cv::Mat out;
        cv::GaussianBlur(in, out, cv::Size(11, 11), 1.5, 1.5, cv::BORDER_REFLECT_101);
        return out;
    };
    const cv::Mat meanA = blur(a), meanB = blur(b);
    const cv::Mat varA = blur(a.mul(a)) - meanA.mul(meanA), varB = blur(b.mul(b)) - meanB.mul(meanB),
                  cov = blur(a.mul(b)) - meanA.mul(meanB);
    const cv::Scalar c1 = cv::Scalar::all(0.01 * 0.01), c2 = cv::Scalar::all(0.03 * 0.03);
    cv::Mat numerator = (2 * meanA.mul(meanB) + c1), second = (2 * cov + c2), denominator = (meanA.mul(meanA) + meanB.mul(meanB) + c1),
            third = (varA + varB + c2), map;
    cv::divide(numerator.mul(second), denominator.mul(third), map);
    cv::Mat grey;
    cv::transform(map, grey, cv::Matx13f(1.0f / 3, 1.0f / 3, 1.0f / 3));
    return grey;
}

}  // namespace dpl
