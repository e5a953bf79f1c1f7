// The filters: which control samples are made of a field's samples, and which kernel reads them.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/filter.h"

#include "filtering/prefilter.h"
#include "filtering/quasi_interpolant.h"
#include "volume/available_memory.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <utility>

namespace isocast {

namespace {

/// In the order of the enumeration.
constexpr std::array<std::string_view, 5> names{"linear", "bspline", "interpolating", "exact",
                                                "catmull-rom"};

} // namespace

Filter filter_from_name(std::string_view name) {
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (names[i] == name) return static_cast<Filter>(i);
    }
    throw InputError(fmt::format("unknown filter '{}' (known: {})", name, fmt::join(names, ", ")));
}

std::string_view filter_name(Filter filter) {
    return names[static_cast<std::size_t>(filter)];
}

Kernel kernel_of(Filter filter) {
    switch (filter) {
    case Filter::Linear:
        return Kernel::Linear;
    case Filter::BSpline:
    case Filter::Interpolating:
    case Filter::Exact:
        return Kernel::BSpline;
    case Filter::CatmullRom:
        return Kernel::CatmullRom;
    }
    return Kernel::BSpline;
}

bool share_control_samples(Filter a, Filter b) {
    const auto are_plain = [](Filter filter) {
        return filter != Filter::Interpolating && filter != Filter::Exact;
    };
    return a == b || (are_plain(a) && are_plain(b));
}

std::shared_ptr<const FieldSource> control_samples(std::shared_ptr<const FieldSource> samples,
                                                   Filter filter, const Progress& progress,
                                                   double memory_bytes) {
    switch (filter) {
    case Filter::Linear:
    case Filter::BSpline:
    case Filter::CatmullRom:
        return samples;
    case Filter::Interpolating:
        return std::make_shared<QuasiInterpolant>(std::move(samples));
    case Filter::Exact:
        return spline_coefficients(*samples, progress,
                                   std::min(memory_bytes, available_memory_bytes()));
    }
    return samples;
}

} // namespace isocast
