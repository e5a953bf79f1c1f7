// SPDX-License-Identifier: MPL-2.0
#include "raycaster/effects/curvature_measure.h"

#include <array>
#include <cmath>
#include <numbers>

namespace isocast {

double curvature_measure(CurvatureMeasure measure, double k1, double k2) {
    switch (measure) {
    case CurvatureMeasure::K1:
        return k1;
    case CurvatureMeasure::K2:
        return k2;
    case CurvatureMeasure::Mean:
        return (k1 + k2) / 2;
    case CurvatureMeasure::Gauss:
        return k1 * k2;
    case CurvatureMeasure::ShapeIndex: // atan2 needs no quotient, which umbilics would not have
        return 2 / std::numbers::pi * std::atan2(k1 + k2, k1 - k2);
    case CurvatureMeasure::Curvedness:
        return std::hypot(k1, k2) / std::numbers::sqrt2;
    }
    throw std::logic_error("unknown curvature measure");
}

std::string_view name_of(CurvatureMeasure measure) {
    constexpr std::array<std::string_view, 6> names{"first principal curvature",
                                                    "second principal curvature",
                                                    "mean curvature",
                                                    "Gauss curvature",
                                                    "shape index",
                                                    "curvedness"};
    return names.at(static_cast<std::size_t>(measure));
}

} // namespace isocast
