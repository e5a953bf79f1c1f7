// The uniform cubic B-spline: weights and their derivatives.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/bspline.h"

namespace isocast {

std::array<double, 4> bspline_weights(double a) {
    const double b = 1 - a;
    // w1 and w2 are each other's mirror image; written alike, they are so to the last bit nearly.
    return {b * b * b / 6, ((3 * a - 6) * a * a + 4) / 6, ((3 * b - 6) * b * b + 4) / 6,
            a * a * a / 6};
}

std::array<double, 4> bspline_weights_d1(double a) {
    const double b = 1 - a;
    return {-b * b / 2, (3 * a - 4) * a / 2, (4 - 3 * b) * b / 2, a * a / 2};
}

std::array<double, 4> bspline_weights_d2(double a) {
    return {1 - a, 3 * a - 2, 1 - 3 * a, a};
}

} // namespace isocast
